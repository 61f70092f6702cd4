"""Forget an episode: which decisions would be others, had it never been learned from.

A counterfactual about training, not about a state. It says what the whole course of learning came
to without the episode, so a small cause may show as a great effect, as it does in life.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.words import count, number, percent


@dataclass(frozen=True)
class Changed:
    """A state at which the agent without the episode chooses otherwise."""

    place: int  # Of the state in those that were compared.
    before: int  # Action of the agent.
    after: int  # Action without the episode.
    margin: float  # By which the agent preferred its own.
    margin_after: float  # By which the other one does.


@dataclass(frozen=True, eq=False)
class Forgotten:
    """What an agent would decide without one of its training episodes."""

    episode: int  # Counted from 0.
    length: int  # Steps that it had.
    reward: float  # Sum of its rewards.
    states: NDArray[np.float64]  # [S, D] at which both were asked.
    changed: tuple[Changed, ...]
    options: int  # Of the agent.
    options_after: int
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.


def compare_without(
    mind: Mind, other: Mind, states: NDArray[np.float64], episode: int, length: int, reward: float
) -> Forgotten:
    """Asks an agent, and itself without an episode, at states [S, D]."""
    changed = []
    for place, state in enumerate(states):
        one, two = mind.decide(state), other.decide(state)
        if one.action != two.action:
            changed.append(Changed(place, one.action, two.action, one.margin, two.margin))
    return Forgotten(
        episode=episode,
        length=length,
        reward=reward,
        states=states,
        changed=tuple(changed),
        options=len(mind.view),
        options_after=len(other.view),
    )


def tell_forgotten(told: Forgotten, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences: how much changes, and where most."""
    share = len(told.changed) / max(len(told.states), 1)
    lines = [
        f"Training episode {told.episode} had {count(told.length, 'step')} and earned "
        f"{number(told.reward)}. Without it, {len(told.changed):,} of "
        f"{count(len(told.states), 'decision')} would be others ({percent(share)}), and there "
        f"would be {count(told.options_after, 'option')} instead of {told.options:,}."
    ]
    most = sorted(told.changed, key=lambda change: -min(change.margin, change.margin_after))
    for change in most[:10]:
        lines.append(
            f"State {change.place}: {spec.action_names[change.before]}, by "
            f"{number(change.margin)}, would be {spec.action_names[change.after]}, by "
            f"{number(change.margin_after)}."
        )
    return tuple(lines)
