"""`agent.explain.whole`: what can be asked about an agent as a whole."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.background import Background
from ao2viz.explain.faithful import MOST_TRIED, Trials
from ao2viz.explain.telling import CHECKS
from ao2viz.explain.whole import (
    MOST_SEARCHED,
    MOST_STATES,
    Asking,
    Attended,
    Carriers,
    Comparison,
    Coverage,
    Highlight,
    Muted,
    Novelty,
    Overview,
    Roles,
    compare_minds,
    find_highlights,
    find_roles,
    measure_attention,
    measure_coverage,
    measure_novelty,
    sample_places,
    sample_states,
    states_of,
)
from ao2viz.recording.episode import Episode
from ao2viz.training.loop import evaluation_seed, play

Progress = Callable[[Carriers], bool | None]
"""Called after each option; returning False ends it."""
EpisodeProgress = Callable[[int], bool | None]
"""Told after each episode how many were played; returning False ends it."""


class WholeAgent:
    """Explains an agent as a whole, over the states in which recorded decisions were made.

    Without recorded episodes the options' values stand in for them. Every answer says over how many
    states it is; no more than 20,000 of them, evenly spread, and no more than 400 where each takes
    many decisions.
    """

    def __init__(
        self,
        mind: Mind,
        spec: TaskSpec,
        episodes: Sequence[Episode],
        get_env: Callable[[], gym.Env],
        get_ranges: Callable[[], Ranges],
    ) -> None:
        self._mind, self._spec, self._episodes = mind, spec, tuple(episodes)
        self._get_env, self._get_ranges = get_env, get_ranges
        self._trials = self._try(MOST_TRIED)

    def states(self) -> NDArray[np.float64]:
        """[S, D] the states in which recorded decisions were made; the options' values if none."""
        return states_of(self._mind, self._episodes)

    def overview(self) -> Overview:
        """All that takes no more than seconds."""
        return Overview(
            attention=self.attention(),
            roles=self.roles(),
            coverage=self.coverage(),
            highlights=self.highlights(),
            faithfulness=self.faithfulness() if self._episodes else None,
        )

    def attention(self) -> Attended:
        """What it attends to: the share of each feature in the distances that decided."""
        return measure_attention(self._mind, sample_states(self.states(), MOST_SEARCHED))

    def roles(self, on_progress: Asking | None = None) -> Roles:
        """Which options decide, which support them, which are idle, and which could be spared."""
        return find_roles(self._mind, sample_states(self.states()), on_progress)

    def coverage(self) -> Coverage:
        """How far the states are from what it knows; the farthest by its place in `states`."""
        states = self.states()
        places = sample_places(len(states), MOST_SEARCHED)
        found = measure_coverage(self._mind, states[places])
        return replace(found, farthest=int(places[found.farthest])) if len(places) else found

    def novelty(self, observation: NDArray[np.float64]) -> Novelty:
        """Whether an observation [D] is like nothing that it has met."""
        states = sample_states(self.states(), MOST_SEARCHED)
        found = measure_novelty(self._mind, observation, states)
        return replace(found, faithfulness=self._trials.on(CHECKS[Novelty]))

    def highlights(self, count: int = 5, around: int = 10) -> tuple[Highlight, ...]:
        """The recorded moments in which the choice mattered most, with so many steps around."""
        return find_highlights(self._episodes, count, around)

    def disagreements(
        self, other: Mind, others_states: NDArray[np.float64] | None = None
    ) -> Comparison:
        """Where another agent of the same task would choose differently.

        Args:
            other: Its mind, as in `agent.explain.mind`.
            others_states: [S, D] states to ask at beside this agent's own.

        Raises:
            ValueError: If the two are of different tasks.
        """
        states = self.states()
        if others_states is not None and others_states.shape[1:] == states.shape[1:]:
            states = np.concatenate([states, others_states])
        found = compare_minds(self._mind, other, states)
        return replace(found, faithfulness=self._trials.on(CHECKS[Comparison]))

    def faithfulness(self, on_progress: Asking | None = None) -> Faithfulness:
        """How often explanations agree with the agent, at as many states as it says."""
        return self._try(MOST_STATES).on(CHECKS[Overview], on_progress)

    def _try(self, most_tried: int) -> Trials:
        decisions = [decision for episode in self._episodes for decision in episode.decisions]
        return Trials(self._mind, self._spec, decisions, self._get_ranges, most_tried)

    def carriers(
        self,
        options: int | Sequence[int] = 5,
        episodes: int = 10,
        seed: int = 0,
        on_progress: Progress | None = None,
        on_episode: EpisodeProgress | None = None,
    ) -> Carriers:
        """Which options carry the return: each is muted, and the same episodes are played.

        Args:
            options: Ids, or how many of those that decide most often.
            episodes: Greedy ones to play for each; those of `AO2.evaluate` with the same seed.
            seed: As for `AO2.evaluate`.
            on_progress: Told what is known after each option; returning False ends it.
            on_episode: Told after each episode how many were played; returning False ends it.
        """
        if isinstance(options, int):
            muted: Sequence[int] = self.roles().deciding[:options].tolist()
        else:
            muted = options
        found = measure_carriers(
            self._mind, self._get_env(), self._spec, muted, episodes, seed, on_progress, on_episode
        )
        return replace(found, faithfulness=self._trials.on(CHECKS[Carriers]))

    def carriers_in_background(
        self, options: int | Sequence[int] = 5, episodes: int = 10, seed: int = 0
    ) -> Background[Carriers]:
        """`carriers` in a thread of its own; the agent's environment is busy meanwhile."""
        own = WholeAgent(
            self._mind.copy(), self._spec, self._episodes, self._get_env, self._get_ranges
        )
        return Background(lambda report: own.carriers(options, episodes, seed, report))


def measure_carriers(
    mind: Mind,
    env: gym.Env,
    spec: TaskSpec,
    options: Sequence[int],
    episodes: int,
    seed: int = 0,
    on_progress: Progress | None = None,
    on_episode: EpisodeProgress | None = None,
) -> Carriers:
    """Plays the same greedy episodes with all options, and then without each of these.

    One at a time: two options that stand in for each other are each without loss. Called off, it
    tells of the options without which all episodes were played.
    """
    smoothing, played = mind.config.action_smoothing, 0

    def play_all() -> tuple[list[float], bool]:
        nonlocal played
        returns: list[float] = []
        while len(returns) < episodes:
            start = evaluation_seed(seed, len(returns))
            returns.append(play(env, spec, mind.act, start, smoothing))
            played += 1
            if on_episode is not None and on_episode(played) is False:
                return returns, False
        return returns, True

    returns, goes_on = play_all()
    whole = np.array(returns)
    muted: list[Muted] = []

    def tell(*, is_complete: bool) -> Carriers:
        order = sorted(muted, key=lambda one: (-one.loss, one.option))
        return Carriers(float(whole.mean()), len(whole), seed, tuple(order), is_complete)

    for option in options:
        if not goes_on:
            break
        with mind.muted(option):
            returns, goes_on = play_all()
        if len(returns) < episodes:
            break
        losses = whole - np.array(returns)
        error = losses.std(ddof=1) / np.sqrt(episodes) if episodes > 1 else np.nan
        mean = float(np.mean(returns))
        muted.append(Muted(option, mean, float(losses.mean()), float(error)))
        is_last = len(muted) == len(options)
        if on_progress is not None and on_progress(tell(is_complete=is_last)) is False:
            break
    return tell(is_complete=len(muted) == len(options))
