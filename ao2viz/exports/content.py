"""What an export is made of: an agent, the chosen episodes, and a way to say how far it is."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.forest import ForestView
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import unlimited
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.faithful import Trials
from ao2viz.explain.sentence import Explanation
from ao2viz.explain.telling import CHECKS
from ao2viz.explain.why import Why, explain_why
from ao2viz.exports.escaping import printable_names
from ao2viz.recording.episode import Episode
from ao2viz.store.saved import SavedAgent

Progress = Callable[[float], None]
"""Is told the share that is done, in [0, 1], many times; may raise to stop the export."""


class Numbered(NamedTuple):
    """A recorded episode and its number in the file, from 0."""

    number: int
    episode: Episode


class Step(NamedTuple):
    """One recorded step in numbers and in words."""

    number: int  # From 0.
    decision: Decision
    reward: float
    said: Explanation
    is_faithful: bool  # What it is explained with adds up to the choice.


@dataclass(frozen=True, eq=False)
class Content:
    """What the writers of all formats are given."""

    saved: SavedAgent
    episodes: tuple[Numbered, ...]  # The chosen ones; may be none.
    step: int | None  # Of the latest chosen episode, where one picture shows one decision.
    env_id: str  # Where the environment itself is needed; may name a module to import.
    progress: Progress
    option: int = NO_OPTION  # Where one option is shown.

    @cached_property
    def spec(self) -> TaskSpec:
        """The agent's task, with names in which every character can be printed."""
        return printable_names(self.saved.spec)

    @property
    def view(self) -> ForestView:
        """The agent's forest as it was saved."""
        return self.saved.forest_view()

    @property
    def decisions(self) -> list[Decision]:
        """Those of all chosen episodes."""
        return [decision for _, episode in self.episodes for decision in episode.decisions]

    @cached_property
    def faithfulness(self) -> Faithfulness:
        """How often what is told of decisions agrees with the agent; tried once."""
        mind, n_features = Mind(self.saved.config, self.saved.state), self.spec.n_features
        trials = Trials(mind, self.spec, self.decisions, lambda: unlimited(n_features))
        return trials.on(CHECKS[Why])

    @property
    def chosen(self) -> Numbered:
        """The one episode of formats that show one: the latest of those chosen.

        Raises:
            ValueError: If there is none.
        """
        self.need_episodes()
        return self.episodes[-1]

    def need_episodes(self) -> None:
        """Makes sure that there is something to show.

        Raises:
            ValueError: If no episode is recorded; says how to record one.
        """
        if not self.episodes:
            raise ValueError(
                "Expected a recorded episode, but this agent has none. Record one first: "
                "ao2viz record FILE, or agent.record_episode(seed)."
            )

    def steps(self, numbered: Numbered) -> Iterator[Step]:
        """Every step of an episode, with the sentence that belongs to it."""
        episode, view = numbered.episode, self.view
        for t, (decision, reward) in enumerate(
            zip(episode.decisions, episode.rewards.tolist(), strict=True)
        ):
            why = explain_why(decision, self.spec, view)
            yield Step(t, decision, reward, why.explanation, why.is_faithful)

    def all_steps(self) -> Iterator[tuple[int, Step]]:
        """Every step of every chosen episode, with the episode's number; tells the progress."""
        total = sum(len(episode) for _, episode in self.episodes)
        done = 0
        for numbered in self.episodes:
            for step in self.steps(numbered):
                yield numbered.number, step
                done += 1
                self.progress(done / total)


def path_elements(decision: Decision, voter: int = 0) -> list[dict[str, Any]]:
    """`option` and `distance` of each option on the path to a voter, the root first."""
    options = decision.path_of(voter).tolist() if len(decision.voters) else []
    distances = decision.path_distances[voter, : len(options)].tolist() if options else []
    return [
        {"option": option, "distance": distance}
        for option, distance in zip(options, distances, strict=True)
    ]


def option_or_none(option: int) -> int | None:
    """An option's id, None where there is no option."""
    return None if option == NO_OPTION else int(option)


def number_or_none(value: float) -> float | None:
    """A number, None where it is unknown."""
    return float(value) if math.isfinite(value) else None
