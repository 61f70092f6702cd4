"""The record of one decision: what was seen, which options spoke, and what they expected."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

NO_OPTION = -1
"""Stands where an option id is missing: a root's parent, the padding of a path."""


class DecideBy(Enum):
    """Who chooses the action."""

    VOTE = "vote"
    """The most similar options, each weighted by its share."""
    PATH = "path"
    """The single most similar option alone, and how its weights change around it."""


@dataclass(frozen=True, eq=False)
class Decision:
    """One inference and everything that led to it; made when the action is chosen, never after.

    `D` counts features, `A` actions, `K` the options that spoke (1 by path, up to `voters` by vote,
    0 while the forest is still empty), `P` the options on the longest path.
    """

    observation: NDArray[np.float64]  # [D] as the environment gave it.
    action: int  # The index that was chosen, in [0, A).
    decide_by: DecideBy
    action_values: NDArray[np.float64]  # [A] what each action is expected to earn (discounted).
    voters: NDArray[np.int64]  # [K] option ids, the most similar first.
    shares: NDArray[np.float64]  # [K] at least 0, adding up to 1.
    voter_weights: NDArray[np.float64]  # [K, A] the voters' weights at this moment.
    slopes: NDArray[np.float64]  # [A, D] by path: what a unit of each feature adds; else 0.
    paths: NDArray[np.int64]  # [K, P] root … voter, one row a voter, padded with NO_OPTION.
    path_distances: NDArray[np.float64]  # [K, P] observation to option; NaN where padded.
    runner_up_option: int  # The second most similar option, NO_OPTION if there is none.
    runner_up_distance: float  # Its distance, NaN if there is none.
    explored: bool  # The action was drawn at random instead of chosen.
    is_tie: bool  # Several actions were expected to earn exactly the most.
    created: int = NO_OPTION  # The option made for this observation, if one was.

    @property
    def best_action(self) -> int:
        """The action expected to earn the most; ties go to the first."""
        return int(np.argmax(self.action_values))

    @property
    def runner_up_action(self) -> int:
        """The best of the actions that were not chosen; the action itself if there is no other."""
        others = np.delete(np.arange(len(self.action_values)), self.action)
        if len(others) == 0:
            return self.action
        return int(others[np.argmax(self.action_values[others])])

    @property
    def margin(self) -> float:
        """By how much the chosen action is expected to earn more than the runner-up.

        Negative when an exploration step took an action that was not the best.
        """
        return float(self.action_values[self.action] - self.action_values[self.runner_up_action])

    @property
    def path(self) -> NDArray[np.int64]:
        """Ids from the root to the most similar option; empty while there is none."""
        return self.path_of(0) if len(self.voters) else np.empty(0, np.int64)

    @property
    def distance(self) -> float:
        """From the observation to the most similar option; NaN while there is none."""
        return float(self.path_distances[0, len(self.path) - 1]) if len(self.voters) else np.nan

    def path_of(self, voter: int) -> NDArray[np.int64]:
        """Ids from the root to the voter at this position in `voters`, without padding."""
        row = self.paths[voter]
        return row[row != NO_OPTION]
