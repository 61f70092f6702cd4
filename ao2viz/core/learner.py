"""What every agent of this project can do, whichever preset it follows."""

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.arrays import Arrays
from ao2viz.core.config import Config
from ao2viz.core.decision import Decision
from ao2viz.core.forest import ForestView
from ao2viz.core.growth import GrowthEvent


class Learner(Protocol):
    """Chooses actions and learns from what follows.

    The life of one episode: `start(o0)`, then per step `decide(explore=True)`, the environment,
    `observe(...)`. Asking `decide_at` changes nothing. All observations are float64 arrays of
    shape [D].
    """

    n_steps: int  # Steps learned from so far.

    @property
    def config(self) -> Config:
        """Every setting, frozen; only `change` replaces it."""
        ...

    def start(self, observation: NDArray[np.float64]) -> tuple[GrowthEvent, ...]:
        """Begins an episode; what an unfinished one left behind is dropped."""
        ...

    def decide(self, explore: bool = True) -> Decision:
        """Decides for the observation of the latest `start` or `observe`."""
        ...

    def observe(
        self,
        decision: Decision,
        reward: float,
        observation: NDArray[np.float64],
        terminated: bool,
        truncated: bool,
    ) -> tuple[GrowthEvent, ...]:
        """Learns from one step: accommodates what was seen, assimilates what was earned."""
        ...

    def decide_at(self, observation: NDArray[np.float64]) -> Decision:
        """What the agent would do, greedily, if it saw this; learns nothing, draws nothing."""
        ...

    def act_at(self, observation: NDArray[np.float64]) -> int:
        """The action of `decide_at`, without the record; for long evaluations."""
        ...

    def sleep(self) -> tuple[GrowthEvent, ...]:
        """Lets what was learned settle, and cleanses it if so set; call before evaluating."""
        ...

    def cleanse(self, tolerance: float) -> tuple[GrowthEvent, ...]:
        """Lets go of options that it can do without; see `plan_cleansing` for the tolerance.

        Raises:
            ValueError: If this agent cannot tell which.
        """
        ...

    def change(self, settings: Mapping[str, Any]) -> None:
        """Takes over settings that `check_changeable` allows, their values already checked."""
        ...

    def view(self) -> ForestView:
        """A frozen copy of the forest."""
        ...

    def get_state(self) -> Arrays:
        """Copies of everything needed to continue to the bit from a fresh episode."""
        ...

    def set_state(self, state: Arrays) -> None:
        """Takes over what `get_state` gave.

        Raises:
            ValueError: If arrays are missing or do not fit one another.
        """
        ...
