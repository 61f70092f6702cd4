"""Two agents of one task beside each other: at the same states, and from the same seeds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.task import TaskSpec, make_env
from ao2viz.explain.compare import ForestDiff, Setting, diff_forests, diff_settings
from ao2viz.explain.whole import Comparison, compare_minds, sample_states
from ao2viz.extras import need
from ao2viz.recording.episode import Episode
from ao2viz.training.loop import evaluation_seed, play, play_recorded


@dataclass(frozen=True, eq=False)
class Returns:
    """Returns of episodes of one agent, with the 95 % bootstrap interval of what stands for all."""

    scores: NDArray[np.float64]  # [E]
    iqm: float  # Interquartile mean; NaN without episodes.
    interval: tuple[float, float] | None  # None below two episodes.


def sum_up(scores: Sequence[float]) -> Returns:
    """The interquartile mean of episode returns and its interval.

    Episodes are what is resampled: it says how one agent's next episodes would go, and nothing of
    how another agent would learn.

    Raises:
        ValueError: If there is no SciPy.
    """
    need("experiments", ["scipy"])
    from ao2viz.experiments.statistics import (  # noqa: PLC0415 -- needs an extra.
        interquartile_mean,
        iqm_interval,
    )

    found = np.array(scores, np.float64)
    if len(found) == 0:
        return Returns(found, float("nan"), None)
    return Returns(found, interquartile_mean(found), iqm_interval(found))


@dataclass(frozen=True, eq=False)
class Beside:
    """What two agents have in common and what not, without playing."""

    episode: Comparison  # At the states of one recorded episode; places are its steps.
    recorded: Comparison  # At recorded states of both.
    forests: ForestDiff
    settings: tuple[Setting, ...]
    returns: tuple[Returns, Returns]  # Of the greedy episodes that each was recorded with.


def put_beside(
    one: Mind,
    other: Mind,
    episode: Episode | None,
    recorded: tuple[Sequence[Episode], Sequence[Episode]],
) -> Beside:
    """Compares two agents; takes some seconds with ten thousand options.

    Raises:
        ValueError: If they do not have the same features and actions.
    """
    forests = diff_forests(one, other)
    nothing = np.empty((0, one.forest.n_features))
    steps = episode.observations[:-1] if episode is not None else nothing
    states = [e.observations[:-1] for episodes in recorded for e in episodes if len(e)]
    sampled = sample_states(np.concatenate(states)) if states else nothing
    greedy = [[e.total_reward for e in episodes if not e.is_training] for episodes in recorded]
    return Beside(
        episode=compare_minds(one, other, steps),
        recorded=compare_minds(one, other, sampled),
        forests=forests,
        settings=diff_settings(one.config, other.config),
        returns=(sum_up(greedy[0]), sum_up(greedy[1])),
    )


@dataclass(frozen=True, eq=False)
class Duel:
    """Two agents from the same seeds, as far as they have played."""

    one: Episode
    other: Episode
    returns: tuple[Returns, Returns]  # Greedy episodes, pair by pair from the same seed.
    difference: Returns  # Of each pair: the first less the second.
    played: int
    planned: int

    @property
    def parting(self) -> int | None:
        """The first step at which their actions differ, or one has ended; None: they never do."""
        both = min(len(self.one), len(self.other))
        differ = np.flatnonzero(self.one.actions[:both] != self.other.actions[:both])
        if len(differ):
            return int(differ[0])
        return None if len(self.one) == len(self.other) else both


Progress = Callable[[Duel], bool | None]
"""Called after each pair of episodes; returning False ends it."""


def fight(
    one: Mind,
    other: Mind,
    spec: TaskSpec,
    seed: int,
    episodes: int = 20,
    on_progress: Progress | None = None,
) -> Duel:
    """Lets both play greedily, first recorded from `seed`, then for their returns.

    Raises:
        ValueError: If the environment cannot be made here.
    """
    env = make_env(spec.env_id)
    try:
        recorded = tuple(
            play_recorded(env, spec, mind.decide, seed, mind.config.action_smoothing)
            for mind in (one, other)
        )
        scores: list[tuple[float, float]] = []
        while True:
            told = _tell(recorded[0], recorded[1], scores, episodes)
            go_on = on_progress is None or on_progress(told) is not False
            if len(scores) == episodes or not go_on:
                return told
            start = evaluation_seed(seed, len(scores))
            mine, theirs = (
                play(env, spec, mind.act, start, mind.config.action_smoothing)
                for mind in (one, other)
            )
            scores.append((mine, theirs))
    finally:
        env.close()


def _tell(one: Episode, other: Episode, scores: list[tuple[float, float]], planned: int) -> Duel:
    mine, theirs = [pair[0] for pair in scores], [pair[1] for pair in scores]
    difference = sum_up([a - b for a, b in scores])
    return Duel(one, other, (sum_up(mine), sum_up(theirs)), difference, len(scores), planned)
