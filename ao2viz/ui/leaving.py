"""What has left the screen, until it can go for good."""

import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

PATIENCE_S = 3.0
"""Longer than a slow browser takes for one frame."""


class Leaver(Protocol):
    """Something on a page that can go in two steps."""

    def hide(self) -> None:
        """Takes it out of sight."""
        ...

    def remove(self) -> None:
        """Takes it off the page."""
        ...


class Leaving:
    """Hides at once, removes later.

    Within one frame viser's page applies changes after removals, and complains of a change to what
    it has just removed. So nothing is removed that was changed a moment ago.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._leavers: deque[tuple[float, Leaver]] = deque()  # Since when they are hidden.

    def add(self, leaver: Leaver) -> None:
        """Hides something that must not be changed any more."""
        leaver.hide()
        self._leavers.append((self._clock(), leaver))

    def tick(self) -> None:
        """Removes what has been hidden for long enough; to be called now and then."""
        while self._leavers and self._clock() - self._leavers[0][0] >= PATIENCE_S:
            self._leavers.popleft()[1].remove()
