"""A ledger of one weight of the `paper` preset: every reward that moved it, to the bit.

Nothing of the kind is kept in ordinary learning. A learner that is given a ledger writes into it
what moves the one weight it is about; so it needs some 60 bytes for each such movement and 16 for
each reward in it, however long the learning takes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Movement(NamedTuple):
    """One change of the weight; `n` rewards share in it."""

    first_step: int  # The agent's step in which the action was taken, the first being 1.
    delays: NDArray[np.int64]  # [n] steps from there to each reward.
    rewards: NDArray[np.float64]  # [n] as the agent learns from them.
    after: float  # What was expected after the last of them; 0 unless credit bootstraps.
    rate: float  # How far the weight moved towards what was earned; NaN: it was added.


class Ledger:
    """What moved the weight of one action at one option. Mutable: its learner writes to it."""

    def __init__(self, option: int, action: int, gamma: float) -> None:
        self.option, self.action, self.gamma = option, action, gamma
        self.movements: list[Movement] = []

    def is_about(self, option: int, action: int) -> bool:
        """Whether this is the weight that the ledger is about."""
        return (option, action) == (self.option, self.action)

    def add(self, first_step: int, delay: int, reward: float) -> None:
        """Notes a reward that was added, discounted once for each step of the delay."""
        delays, rewards = np.array([delay]), np.array([reward], np.float64)
        self.movements.append(Movement(first_step, delays, rewards, 0.0, np.nan))

    def move(self, first_step: int, rewards: list[float], after: float, rate: float) -> None:
        """Notes a step of the running mean towards the discounted sum of these rewards."""
        values = np.array(rewards, np.float64)
        self.movements.append(Movement(first_step, np.arange(len(values)), values, after, rate))

    def replay(self) -> float:
        """The weight that these movements make, in the learner's own order of operations."""
        weight = 0.0
        for movement in self.movements:
            if np.isnan(movement.rate):
                credit = float(movement.rewards[0])
                for _ in range(int(movement.delays[0])):
                    credit *= self.gamma
                weight += credit
                continue
            earned = movement.after
            for reward in movement.rewards[::-1].tolist():
                earned = reward + self.gamma * earned
            weight += movement.rate * (earned - weight)
        return weight

    def portions(self) -> list[tuple[NDArray[np.float64], float]]:
        """What each movement's rewards [n], and what was expected after them, are of the weight.

        They add up to it, but for rounding: of a running mean, later movements have taken their
        part from earlier ones.
        """
        left, found = 1.0, []
        for movement in reversed(self.movements):
            own = 1.0 if np.isnan(movement.rate) else movement.rate
            discounts = self.gamma**movement.delays
            after = self.gamma ** len(movement.rewards) * movement.after
            found.append((left * own * discounts * movement.rewards, left * own * after))
            left *= 1.0 if np.isnan(movement.rate) else 1.0 - movement.rate
        return found[::-1]
