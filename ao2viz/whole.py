"""`agent.explain.whole`: what can be asked about an agent as a whole."""

from collections.abc import Callable, Sequence

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.background import Background
from ao2viz.explain.faithful import Faithfulness, measure_faithfulness
from ao2viz.explain.whole import (
    MOST_STATES,
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
    sample_states,
)
from ao2viz.recording.episode import Episode
from ao2viz.training.loop import evaluation_seed, play

Progress = Callable[[Carriers], bool | None]
"""Called after each option; returning False ends it."""


class WholeAgent:
    """Explains an agent as a whole, over the states in which recorded decisions were made.

    Without recorded episodes the options' values stand in for them. Every answer says over how many
    states it is; no more than 400 of them, evenly spread, where each takes many decisions.
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

    def states(self) -> NDArray[np.float64]:
        """[S, D] the states in which recorded decisions were made; the options' values if none."""
        recorded = [episode.observations[:-1] for episode in self._episodes if len(episode)]
        view = self._mind.view
        return np.concatenate(recorded) if recorded else view.values[view.is_alive]

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
        return measure_attention(self._mind, self.states())

    def roles(self) -> Roles:
        """Which options decide, which support them, which are idle, and which could be spared."""
        return find_roles(self._mind, sample_states(self.states()))

    def coverage(self) -> Coverage:
        """How far the states are from what it knows."""
        return measure_coverage(self._mind, self.states())

    def novelty(self, observation: NDArray[np.float64]) -> Novelty:
        """Whether an observation [D] is like nothing that it has met."""
        return measure_novelty(self._mind, observation, self.states())

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
        return compare_minds(self._mind, other, states)

    def faithfulness(self) -> Faithfulness:
        """How often explanations agree with the agent, on recorded decisions."""
        decisions = [decision for episode in self._episodes for decision in episode.decisions]
        if decisions:
            kept = np.unique(np.linspace(0, len(decisions) - 1, MOST_STATES).astype(np.int64))
            decisions = [decisions[n] for n in kept]
        return measure_faithfulness(self._mind, self._spec, decisions, self._get_ranges())

    def carriers(
        self,
        options: int | Sequence[int] = 5,
        episodes: int = 10,
        seed: int = 0,
        on_progress: Progress | None = None,
    ) -> Carriers:
        """Which options carry the return: each is muted, and the same episodes are played.

        Args:
            options: Ids, or how many of those that decide most often.
            episodes: Greedy ones to play for each; those of `AO2.evaluate` with the same seed.
            seed: As for `AO2.evaluate`.
            on_progress: Told what is known after each option; returning False ends it.
        """
        if isinstance(options, int):
            muted: Sequence[int] = self.roles().deciding[:options].tolist()
        else:
            muted = options
        return measure_carriers(
            self._mind, self._get_env(), self._spec, muted, episodes, seed, on_progress
        )

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
) -> Carriers:
    """Plays the same greedy episodes with all options, and then without each of these.

    One at a time: two options that stand in for each other are each without loss.
    """
    smoothing = mind.config.action_smoothing

    def play_all() -> list[float]:
        seeds = [evaluation_seed(seed, n) for n in range(episodes)]
        return [play(env, spec, mind.act, start, smoothing) for start in seeds]

    whole = np.array(play_all())
    muted: list[Muted] = []

    def tell(*, is_complete: bool) -> Carriers:
        order = sorted(muted, key=lambda one: (-one.loss, one.option))
        return Carriers(float(whole.mean()), episodes, seed, tuple(order), is_complete)

    for option in options:
        with mind.muted(option):
            without = np.array(play_all())
        losses = whole - without
        error = losses.std(ddof=1) / np.sqrt(episodes) if episodes > 1 else np.nan
        muted.append(Muted(option, float(without.mean()), float(losses.mean()), float(error)))
        is_last = len(muted) == len(options)
        if on_progress is not None and on_progress(tell(is_complete=is_last)) is False:
            return tell(is_complete=is_last)
    return tell(is_complete=True)
