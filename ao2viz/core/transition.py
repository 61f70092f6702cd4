"""One step of the environment, as an agent learns from it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Transition(NamedTuple):
    """What was seen, done, earned and seen next; `D` counts features."""

    before: NDArray[np.float64]  # [D]
    action: int
    reward: float
    after: NDArray[np.float64]  # [D]
    terminated: bool
    ended: bool  # The last step of its episode, for whatever reason.

    def to_row(self) -> NDArray[np.float64]:
        """[2 D + 4] numbers."""
        return np.array(
            [*self.before, *self.after, self.action, self.reward, self.terminated, self.ended]
        )

    @classmethod
    def from_row(cls, row: NDArray[np.float64]) -> "Transition":
        """The step that `to_row` wrote."""
        d = (len(row) - 4) // 2
        action, reward, terminated, ended = row[2 * d :].tolist()
        before, after = row[:d].copy(), row[d : 2 * d].copy()
        return cls(before, int(action), reward, after, bool(terminated), bool(ended))
