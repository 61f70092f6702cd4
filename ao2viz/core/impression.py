"""Personal impression: attention that drifts with experience, as in the paper's equation 3."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.arrays import Arrays, take_array

_MOST = 4.0  # A feature counts at most so many times what it would, and at least that part of it.
_MEMORY = 200  # Steps that the moving average of rewards is about; the paper's episode of Pendulum.


class Impression:
    """By how much each of D features counts more, or less, than it would without impression.

    W ← W ± β (U - V), with + while the moving average of rewards rises. W is kept as factors on
    the attention there would be otherwise, all 1 at first, so that it means the same for any unit
    of U and V; and no factor leaves [1/4, 4], so that attention stays finite and above 0.
    """

    def __init__(self, n_features: int, strength: float) -> None:
        """Makes an impression of nothing yet; `strength` is the paper's β."""
        self.factors = np.ones(n_features)
        self._strength = strength
        self._rewards = np.zeros(2)  # Steps, and the moving average of their rewards.

    def move(self, gap: NDArray[np.float64], reward: float) -> None:
        """Takes one step into account.

        `gap` [D] is U - V, from the option that the observation was most similar to up to the
        observation, in a unit in which features compare; `reward` is what the step earned. The
        average rises exactly if a step earns more than it. It starts at the first reward.
        """
        steps, average = self._rewards
        steps = min(steps + 1.0, _MEMORY)
        is_rising = steps > 1 and reward > average
        # Two products rather than one of the difference, which could be too great for a number.
        self._rewards[:] = steps, average + (reward / steps - average / steps)
        moved = self.factors + (self._strength if is_rising else -self._strength) * gap
        self.factors = np.clip(moved, 1.0 / _MOST, _MOST)

    def get_state(self) -> Arrays:
        """Copies of everything needed to continue."""
        return {"impression": np.concatenate([self.factors, self._rewards])}

    def set_state(self, state: Arrays) -> None:
        """Takes over what `get_state` gave.

        Raises:
            ValueError: If the array is missing, or holds what can never have come about.
        """
        d = len(self.factors)
        array = take_array(state, "impression", (d + 2,), np.float64)
        factors, steps = array[:d], array[d]
        within = (factors >= 1.0 / _MOST) & (factors <= _MOST)
        if not (within.all() and np.isfinite(array).all() and 0 <= steps <= _MEMORY):
            raise ValueError(
                f"Expected an impression of factors from {1 / _MOST:g} to {_MOST:g} and finite "
                f"numbers, but got {array}."
            )
        self.factors, self._rewards = factors.copy(), array[d:].copy()


def make_impression(n_features: int, strength: float) -> Impression | None:
    """An impression of nothing yet; None where the setting says that there is to be none."""
    return Impression(n_features, strength) if strength > 0 else None
