"""Ctrl-C that waits for a good moment: what was learned is saved, not torn apart mid-step."""

import signal
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Self

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class DeferredInterrupts:
    """Within `with`, the first Ctrl-C (or a polite kill) only sets `received`.

    A second one raises KeyboardInterrupt at once: a person who asks twice means it.
    """

    def __init__(self, on_first: Callable[[], None]) -> None:
        self.received: signal.Signals | None = None
        self._on_first = on_first
        self._before: dict[signal.Signals, object] = {}

    @property
    def exit_code(self) -> int:
        """What shells expect of a process that ended because of this signal; 0 if none came."""
        return 0 if self.received is None else 128 + self.received

    def __enter__(self) -> Self:
        self._before = {number: signal.signal(number, self._receive) for number in _SIGNALS}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]  # What `signal` returned.

    def _receive(self, number: int, frame: FrameType | None) -> None:
        if self.received is not None:
            raise KeyboardInterrupt
        self.received = signal.Signals(number)
        self._on_first()
