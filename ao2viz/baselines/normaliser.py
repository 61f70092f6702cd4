"""Running mean and variance, for observations and for how large returns are."""

import numpy as np
from numpy.typing import NDArray

_CUT = 10.0  # Standard deviations beyond which an observation says no more.
_LEAST = 1e-8


class Moments:
    """Mean and variance of all rows seen so far; Chan et al. (1979). Mutable: one owner."""

    def __init__(self, size: int) -> None:
        self.mean = np.zeros(size)
        self.variance = np.ones(size)
        self.count = 0.0

    def add(self, rows: NDArray[np.float64]) -> None:
        """Takes in rows [n, size]."""
        n = len(rows)
        total = self.count + n
        shift = rows.mean(axis=0) - self.mean
        squares = self.variance * self.count + rows.var(axis=0) * n
        squares += shift**2 * self.count * n / total
        self.mean = self.mean + shift * n / total
        self.variance = squares / total
        self.count = total

    def apply(self, rows: NDArray[np.float64]) -> NDArray[np.float32]:
        """Rows in standard deviations from the mean, cut at ten."""
        scaled = (rows - self.mean) / np.sqrt(self.variance + _LEAST)
        return np.clip(scaled, -_CUT, _CUT).astype(np.float32)


class RewardScale:
    """Divides rewards by the standard deviation of the running discounted return of each row."""

    def __init__(self, count: int, gamma: float) -> None:
        self.moments = Moments(1)
        self._gamma = gamma
        self._running = np.zeros(count)

    def apply(self, rewards: NDArray[np.float64], ended: NDArray[np.bool_]) -> NDArray[np.float32]:
        """Rewards [T, N] of a rollout, scaled by all seen so far, these included."""
        seen = np.empty_like(rewards)
        for t, row in enumerate(rewards):
            self._running = self._gamma * self._running + row
            seen[t] = self._running
            self._running = np.where(ended[t], 0.0, self._running)
        self.moments.add(seen.reshape(-1, 1))
        return (rewards / np.sqrt(self.moments.variance + _LEAST)).astype(np.float32)
