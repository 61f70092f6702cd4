"""The record of one decision: what was seen, which options spoke, and what they expected."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.card import make_card

NO_OPTION = -1
"""Stands where an option id is missing: a root's parent, the padding of a path."""


class DecideBy(Enum):
    """Who chooses the action."""

    VOTE = "vote"
    """The most similar options, each weighted by its share."""
    PATH = "path"
    """The single most similar option alone, and how its weights change around it."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What a decision expects of the best sequence of actions that it thought of.

    `L` counts its steps, `D` features, `A` actions. What the chosen action is expected to earn is
    the sum over the steps k of gamma^k · (chance of still going on before it) · reward, plus
    gamma^L · (chance of still going on) · worth. There are no steps where nothing is known of
    what the chosen action leads to.
    """

    actions: NDArray[np.int64]  # [L] indices; the first is the chosen one.
    states: NDArray[np.float64]  # [L, D] where it expects to be after each, environment units.
    rewards: NDArray[np.float64]  # [L] expected of each step if it comes to it, not discounted.
    continues: NDArray[np.float64]  # [L] chance that the task has not ended after each step.
    options: NDArray[np.int64]  # [L] the most similar option after each step.
    worth: float  # Expected from there on; 0 if the task has ended for certain.
    outlook_values: NDArray[np.float64]  # [A] what each action was expected to earn before.


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
    plan: Plan | None = None  # None: it did not think ahead.

    @property
    def outlook_values(self) -> NDArray[np.float64]:
        """[A] what each action was expected to earn before any thinking ahead."""
        return self.action_values if self.plan is None else self.plan.outlook_values

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

    def _repr_html_(self) -> str:
        """What notebooks show: numbers only, as a decision does not know its task's names."""
        chosen = f"action {self.action}"
        if self.explored:
            chosen += ", drawn at random to explore"
        elif self.is_tie:
            chosen += ", a tie"
        path = [
            f"{option} ({distance:.3g})"
            for option, distance in zip(
                self.path.tolist(), self.path_distances[:1].ravel().tolist(), strict=False
            )
        ]
        return make_card(
            "Decision",
            [
                ("seen", ", ".join(f"{value:.4g}" for value in self.observation.tolist())),
                ("chosen", chosen),
                *(
                    (f"action {i} expected to earn", f"{value:.6g}")
                    for i, value in enumerate(self.action_values.tolist())
                ),
                ("margin", f"{self.margin:.6g}"),
                ("path (distance)", " → ".join(path) or "there were no options yet"),
                ("decided by", self.decide_by.value),
            ],
        )
