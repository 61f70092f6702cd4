"""Long questions beside other work: started, looked at, called off."""

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Background(Generic[T]):
    """Work in a thread of its own that reports how far it has come.

    The work gets a function to call with its latest state; that gives False once it is to end.
    What it works on has to be its own: give it a `Mind.copy`.
    """

    def __init__(self, work: Callable[[Callable[[T], bool]], T]) -> None:
        """Starts the work."""
        self._latest: T | None = None
        self._result: T | None = None
        self._error: BaseException | None = None
        self._is_cancelled = threading.Event()
        self._is_done = threading.Event()
        # A program that ends does not wait for an answer that nobody asks for any more.
        threading.Thread(target=self._run, args=(work,), daemon=True).start()

    def _run(self, work: Callable[[Callable[[T], bool]], T]) -> None:
        try:
            self._result = self._latest = work(self._report)
        except BaseException as error:
            self._error = error
        finally:
            self._is_done.set()

    def _report(self, state: T) -> bool:
        self._latest = state
        return not self._is_cancelled.is_set()

    @property
    def latest(self) -> T | None:
        """The latest state that the work reported; None before the first."""
        return self._latest

    @property
    def is_done(self) -> bool:
        """Whether it has ended, called off or not."""
        return self._is_done.is_set()

    def cancel(self) -> None:
        """Asks the work to end soon; `result` then gives what it has come to."""
        self._is_cancelled.set()

    def result(self, timeout_s: float | None = None) -> T:
        """Waits for the end and gives the result.

        Raises:
            TimeoutError: If it takes longer.
        """
        if not self._is_done.wait(timeout_s):
            raise TimeoutError(f"This takes more than {timeout_s} s; wait longer, or cancel it.")
        if self._error is not None:
            raise self._error
        assert self._result is not None
        return self._result
