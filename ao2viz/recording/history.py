"""How training went, episode by episode."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class EpisodeSummary(NamedTuple):
    """One finished training episode."""

    end_step: int  # The agent's step count when it ended.
    total_reward: float
    length: int  # Steps.
    options: int  # Living options when it ended.


class History:
    """Summaries of every finished training episode, in order. Mutable: one owner."""

    def __init__(self) -> None:
        self._rows = np.empty((64, len(EpisodeSummary._fields)))
        self._count = 0

    def append(self, summary: EpisodeSummary) -> None:
        """Adds the episode that just ended."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[self._count] = summary
        self._count += 1

    def __len__(self) -> int:
        """Finished episodes."""
        return self._count

    @property
    def summaries(self) -> list[EpisodeSummary]:
        """Every finished episode, the oldest first."""
        return [
            EpisodeSummary(int(s), r, int(n), int(o)) for s, r, n, o in self.to_array().tolist()
        ]

    def to_array(self) -> NDArray[np.float64]:
        """[E, 4] columns as in `EpisodeSummary`; a copy."""
        return self._rows[: self._count].copy()

    @classmethod
    def from_array(cls, array: NDArray[np.float64]) -> "History":
        """The history that `to_array` wrote."""
        history = cls()
        history._rows = np.concatenate([array, np.empty((64, array.shape[1]))])
        history._count = len(array)
        return history
