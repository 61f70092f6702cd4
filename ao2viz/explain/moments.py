"""Moments of an episode that are worth a look, and what makes each of them one.

Lists, marks on charts and conditions all ask here, so that a word means the same everywhere.
"""

from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config
from ao2viz.core.decision import NO_OPTION
from ao2viz.explain.sentence import is_close
from ao2viz.explain.whole import radius_in
from ao2viz.explain.words import number
from ao2viz.recording.episode import Episode

MOST_OF_A_KIND = 3
"""Of each kind so many moments are listed, the most striking ones."""

_STRIKING = 2.0  # A reward drop stands out by so many standard deviations of all changes.


class MomentKind(Enum):
    """Why a moment is worth a look; the values are what people read, and type in conditions."""

    LOW_MARGIN = "close call"
    """The best two actions were expected to earn almost the same; see `is_close`."""
    EXPLORED = "explored"
    """The action was drawn at random."""
    CREATED = "new option"
    """An option was made for what was seen."""
    REWARD_DROP = "reward drop"
    """The reward fell by more than two standard deviations of its changes in this episode."""
    UNSEEN = "never seen"
    """Farther from every option than any of them stands for; see `radius_of`."""
    END = "end"
    """After the last step."""


@dataclass(frozen=True)
class Moment:
    """One moment to go to."""

    step: int
    kind: MomentKind
    words: str  # What makes it one, with its number: "low margin 0.0324".


@dataclass(frozen=True, eq=False)
class Course:
    """An episode as columns [T], one row a step; what conditions, lists and charts read."""

    margins: NDArray[np.float64]
    distances: NDArray[np.float64]  # To the most similar option; NaN where there was none.
    returns: NDArray[np.float64]  # Before each step: the sum of the rewards so far.
    drops: NDArray[np.float64]  # By how much the reward fell since the step before; 0 at first.
    ties: NDArray[np.bool_]
    flags: dict[MomentKind, NDArray[np.bool_]]  # The end is none: it lies after the last step.


@lru_cache(maxsize=32)
def course_of(episode: Episode, config: Config | None) -> Course:
    """The columns of an episode; remembered, for every browser asks at every tick.

    Without the agent's settings nothing is known to have never been seen.
    """
    decisions, rewards = episode.decisions, episode.rewards
    distances = np.array([d.distance for d in decisions], np.float64)
    drops = np.zeros(len(rewards))
    drops[1:] = np.maximum(rewards[:-1] - rewards[1:], 0.0)
    spread = float(np.diff(rewards).std()) if len(rewards) > 1 else 0.0
    radius = radius_in(config) if config is not None else np.inf
    return Course(
        margins=np.array([d.margin for d in decisions], np.float64),
        distances=distances,
        returns=np.cumsum(rewards) - rewards,
        drops=drops,
        ties=np.array([d.is_tie for d in decisions], np.bool_),
        flags={
            MomentKind.LOW_MARGIN: np.array([is_close(d) for d in decisions], np.bool_),
            MomentKind.EXPLORED: np.array([d.explored for d in decisions], np.bool_),
            MomentKind.CREATED: np.array([d.created != NO_OPTION for d in decisions], np.bool_),
            MomentKind.REWARD_DROP: (drops > 0) & (drops > _STRIKING * spread),
            MomentKind.UNSEEN: distances > radius,
        },
    )


@lru_cache(maxsize=32)
def find_moments(
    episode: Episode, config: Config | None, most: int = MOST_OF_A_KIND
) -> tuple[Moment, ...]:
    """The moments to go to, in the order of their steps; the end is the last.

    Of each kind the most striking: the lowest margins (close calls or not), the dearest
    explorations, the new options of what was least like anything known, the biggest reward drops,
    the states farthest from any option.
    """
    course = course_of(episode, config)
    margins, distances, flags = course.margins, course.distances, course.flags
    chosen = ~(flags[MomentKind.EXPLORED] | course.ties)
    unseen = flags[MomentKind.UNSEEN]
    found: list[Moment] = []
    for kind, where, order, value, name in (
        (MomentKind.LOW_MARGIN, chosen, margins, margins, ""),
        (MomentKind.EXPLORED, flags[MomentKind.EXPLORED], margins, margins, ", margin"),
        (MomentKind.CREATED, flags[MomentKind.CREATED], -distances, distances, ", distance"),
        (MomentKind.REWARD_DROP, course.drops > 0, -course.drops, course.drops, ""),
        (MomentKind.UNSEEN, ~np.isnan(distances), -distances, distances, ", distance"),
    ):
        steps = np.flatnonzero(where)
        ranked = steps[np.argsort(order[steps], kind="stable")][:most]
        for step in ranked.tolist():
            said = f"{_name(kind, bool(unseen[step]))}{name} {number(float(value[step]))}"
            found.append(Moment(step, kind, said))
    found.sort(key=lambda moment: moment.step)
    ending = "still under way"
    if episode.terminated:
        ending = "the task ended"
    elif episode.truncated:
        ending = "time was up"
    last = Moment(len(episode), MomentKind.END, f"end: {ending}")
    return (*found, last)


def _name(kind: MomentKind, is_unseen: bool) -> str:
    if kind is MomentKind.LOW_MARGIN:
        return "low margin"
    if kind is MomentKind.UNSEEN:
        return kind.value if is_unseen else "far from known"
    return kind.value
