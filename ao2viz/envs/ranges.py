"""Which observations an environment allows: the bounds of its observation space."""

from dataclasses import dataclass

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ao2viz.envs.task import make_env

# Some spaces name the largest number there is where they mean "unbounded".
_UNBOUNDED = 1e30


@dataclass(frozen=True, eq=False)
class Ranges:
    """The least and greatest value of each of D features, in environment units.

    Of each feature by itself: a space does not say that a sine and a cosine belong together.
    """

    low: NDArray[np.float64]  # [D] −inf: unbounded.
    high: NDArray[np.float64]  # [D] inf: unbounded.

    def allow(self, observation: NDArray[np.float64]) -> bool:
        """Whether an observation [D] lies within."""
        return bool(((self.low <= observation) & (observation <= self.high)).all())


def ranges_of(env: gym.Env) -> Ranges:
    """The ranges of an environment whose observations are one row of numbers."""
    space = env.observation_space
    assert isinstance(space, spaces.Box)
    low, high = space.low.astype(np.float64), space.high.astype(np.float64)
    return Ranges(
        np.where(low < -_UNBOUNDED, -np.inf, low), np.where(high > _UNBOUNDED, np.inf, high)
    )


def ranges_by_id(env_id: str, n_features: int) -> Ranges:
    """The ranges of an environment of this name; all, where it cannot be made here."""
    try:
        env = make_env(env_id)
    except ValueError:
        return unlimited(n_features)
    try:
        found = ranges_of(env)
    finally:
        env.close()
    return found if len(found.low) == n_features else unlimited(n_features)


def unlimited(n_features: int) -> Ranges:
    """Ranges that allow every observation."""
    return Ranges(np.full(n_features, -np.inf), np.full(n_features, np.inf))
