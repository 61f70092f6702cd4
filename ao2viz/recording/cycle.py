"""One step of learning as the perceptual cycle that it is, told apart by what it left behind.

The learners do a step as one; nothing of this is noted meanwhile. What changed is the difference
between the forests before and after, to the bit, so it is what happened, whatever the preset.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import Decision
from ao2viz.core.forest import ForestView
from ao2viz.core.growth import GrowthEvent, GrowthKind


class Stage(Enum):
    """The stages of the cycle, in order; the values are what people read."""

    SAMPLE = "Sample"
    FIND = "Find"
    ACT = "Act"
    ACCOMMODATE = "Accommodate"
    ASSIMILATE = "Assimilate"
    CLEANSE = "Cleanse"

    @property
    def number(self) -> int:
        """0 for the first."""
        return list(Stage).index(self)


@dataclass(frozen=True, eq=False)
class Cycle:
    """A step and what it changed; `W` counts the weights that it changed."""

    n_steps: int  # The agent's steps, this one included.
    decision: Decision
    reward: float
    observation: NDArray[np.float64]  # [D] seen afterwards.
    terminated: bool
    truncated: bool
    events: tuple[GrowthEvent, ...]  # Those of a reset before the step included.
    n_options: int  # Living ones before it.
    options: NDArray[np.int64]  # [W] whose weight changed, the biggest change first.
    actions: NDArray[np.int64]  # [W]
    before: NDArray[np.float64]  # [W]
    after: NDArray[np.float64]  # [W]
    visits: int  # Of the option that decided, for the action done, afterwards; 0 if none decided.

    def of(self, kind: GrowthKind) -> tuple[GrowthEvent, ...]:
        """The events of one kind."""
        return tuple(event for event in self.events if event.kind is kind)


def find_cycle(
    before: ForestView,
    after: ForestView,
    decision: Decision,
    reward: float,
    observation: NDArray[np.float64],
    events: tuple[GrowthEvent, ...],
    n_steps: int,
    *,
    terminated: bool = False,
    truncated: bool = False,
) -> Cycle:
    """What a step changed, by the forests before and after it; options that it made are new."""
    n = len(before.parents)
    alive = before.is_alive & after.is_alive[:n]
    options, actions = np.nonzero((before.weights != after.weights[:n]) & alive[:, None])
    old, new = before.weights[options, actions], after.weights[options, actions]
    order = np.argsort(-np.abs(new - old), kind="stable")
    decided = int(decision.voters[0]) if len(decision.voters) else -1
    return Cycle(
        n_steps=n_steps,
        decision=decision,
        reward=reward,
        observation=observation,
        terminated=terminated,
        truncated=truncated,
        events=events,
        n_options=len(before),
        options=options[order],
        actions=actions[order],
        before=old[order],
        after=new[order],
        visits=int(after.visits[decided, decision.action]) if decided >= 0 else 0,
    )
