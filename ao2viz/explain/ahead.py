"""Where this will lead: the way that the agent expects to go from here, if it follows its policy.

A local, factual explanation of what the agent expects; whether it comes true is the environment's.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.mind import Mind
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.words import capitalised, count, number, percent


class AheadEnd(Enum):
    """Why the way ahead ends where it does."""

    UNKNOWN = "unknown"
    """What the next action does there, nobody knows: no option near has tried it."""
    ENDED = "ended"
    """The task is as good as certain to have ended."""
    LIMIT = "limit"
    """That is as far as was asked."""


@dataclass(frozen=True, eq=False)
class AheadStep:
    """One imagined step."""

    observation: NDArray[np.float64]  # [D] where it is taken.
    option: int  # The most similar one there.
    distance: float  # To it.
    action: int
    reward: float  # Expected of this step, if it comes to it.
    ending: float  # Chance that the task ends in it.
    continues: float  # Chance of still going on after it.
    visits: int  # How often the action was tried by the options that this rests on.


@dataclass(frozen=True, eq=False)
class Ahead:
    """The imagined way from an observation."""

    seen: NDArray[np.float64]  # [D]
    steps: tuple[AheadStep, ...]
    last: NDArray[np.float64]  # [D] where it ends.
    end: AheadEnd
    reward: float  # Expected on the way: each step's, times the chance that it comes to it.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.

    @property
    def stretches(self) -> tuple[tuple[AheadStep, ...], ...]:
        """The steps, those after one another that are nearest to the same option together."""
        found: list[list[AheadStep]] = []
        for step in self.steps:
            if found and found[-1][-1].option == step.option:
                found[-1].append(step)
            else:
                found.append([step])
        return tuple(map(tuple, found))


MOST_STEPS = 1_000
# Below this chance of going on, what comes after no longer matters.
_OVER = 1e-3


def look_ahead(mind: Mind, observation: NDArray[np.float64], limit: int = 50) -> Ahead:
    """Imagines step by step: the greedy action, what it does, what is seen then.

    Raises:
        ValueError: If the agent has not learned what follows an action, or the limit is none.
    """
    if not 1 <= limit <= MOST_STEPS:
        raise ValueError(f"Expected from 1 to {MOST_STEPS:,} steps, but got {limit}.")
    here, continues, reward = observation, 1.0, 0.0
    steps: list[AheadStep] = []
    end = AheadEnd.LIMIT
    while len(steps) < limit:
        decision = mind.decide(here)
        step = mind.expect(here, decision.action)
        if step is None:
            end = AheadEnd.UNKNOWN
            break
        reward += continues * step.reward
        continues *= 1.0 - step.ending
        steps.append(
            AheadStep(
                observation=here,
                option=int(decision.voters[0]) if len(decision.voters) else NO_OPTION,
                distance=decision.distance,
                action=decision.action,
                reward=step.reward,
                ending=step.ending,
                continues=continues,
                visits=step.visits,
            )
        )
        here = step.after
        if continues < _OVER:
            end = AheadEnd.ENDED
            break
    return Ahead(observation, tuple(steps), here, end, reward)


def tell_ahead(ahead: Ahead, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences: one for each option on the way, then how it ends."""
    lines = []
    for stretch in ahead.stretches:
        actions = _tell_actions(stretch, spec)
        text = f"Near option {stretch[0].option}: {actions}, expected to earn "
        text += f"{number(sum(step.reward for step in stretch))}"
        ending = 1.0 - float(np.prod([1.0 - step.ending for step in stretch]))
        if ending >= _OVER:
            text += f", a chance of {percent(ending)} that it ends"
        least = min(step.visits for step in stretch)
        lines.append(f"{text}; the least known step rests on {count(least, 'visit')}.")
    told = f"{count(len(ahead.steps), 'step')} ahead, {number(ahead.reward)} earned"
    match ahead.end:
        case AheadEnd.UNKNOWN:
            lines.append(f"{capitalised(told)}: there it does not know what its action does.")
        case AheadEnd.ENDED:
            lines.append(f"{capitalised(told)}: then it expects the task to have ended.")
        case AheadEnd.LIMIT:
            going = percent(ahead.steps[-1].continues)
            lines.append(f"{capitalised(told)}, and a chance of {going} that it goes on.")
    return tuple(lines)


def _tell_actions(stretch: tuple[AheadStep, ...], spec: TaskSpec) -> str:
    told: list[tuple[str, int]] = []
    for step in stretch:
        name = spec.action_names[step.action]
        if told and told[-1][0] == name:
            told[-1] = name, told[-1][1] + 1
        else:
            told.append((name, 1))
    return ", ".join(name if n == 1 else f"{name} × {n}" for name, n in told)
