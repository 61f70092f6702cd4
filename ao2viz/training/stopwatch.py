"""How long training has worked, without pauses and without waiting for anybody."""

import numpy as np
from numpy.typing import NDArray


class Stopwatch:
    """Runs while a run works, and notes when its episodes ended. Seconds throughout."""

    def __init__(self, n_before: int = 0) -> None:
        """Starts at 0; `n_before` episodes ended earlier, nobody knows when."""
        self._marks = [np.nan] * n_before
        self._worked = 0.0
        self._since: float | None = None

    def start(self, now: float) -> None:
        """Work begins."""
        self._since = now

    def stop(self, now: float) -> None:
        """Work rests."""
        self._worked = self._read(now)
        self._since = None

    def mark(self, now: float) -> None:
        """An episode ended."""
        self._marks.append(self._read(now))

    @property
    def marks(self) -> NDArray[np.float64]:
        """[E] when each episode ended, NaN for those before this run."""
        return np.array(self._marks, np.float64)

    def _read(self, now: float) -> float:
        return self._worked + (now - self._since if self._since is not None else 0.0)
