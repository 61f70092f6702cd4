"""How training went, episode by episode."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class EpisodeSummary(NamedTuple):
    """One finished training episode."""

    end_step: int  # The agent's step count when it ended.
    total_reward: float
    length: int  # Steps.
    options: int  # Living options when it ended.


@dataclass
class History:
    """Summaries of every finished training episode, in order."""

    summaries: list[EpisodeSummary] = field(default_factory=list)

    def append(self, summary: EpisodeSummary) -> None:
        """Adds the episode that just ended."""
        self.summaries.append(summary)

    def __len__(self) -> int:
        """Finished episodes."""
        return len(self.summaries)

    def to_array(self) -> NDArray[np.float64]:
        """[E, 4] columns as in `EpisodeSummary`."""
        return np.array(self.summaries, np.float64).reshape(-1, 4)

    @classmethod
    def from_array(cls, array: NDArray[np.float64]) -> "History":
        """The history that `to_array` wrote."""
        return cls([EpisodeSummary(int(s), float(r), int(n), int(o)) for s, r, n, o in array])
