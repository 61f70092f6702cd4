"""Faithfulness: how often an explanation's action is the agent's, counted and not assumed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import Decision
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.flips import explain_flips
from ao2viz.explain.line import scan_line
from ao2viz.explain.why import explain_why


@dataclass(frozen=True)
class Agreement:
    """On how many of the states that it was tried on an explanation agrees with the agent."""

    agreed: int
    tried: int

    @property
    def share(self) -> float:
        """NaN if nothing could be tried."""
        return self.agreed / self.tried if self.tried else np.nan


@dataclass(frozen=True)
class Faithfulness:
    """How faithful each kind of explanation is."""

    parts: Agreement  # `why`: the parts it names add up to the choice that was made.
    lines: Agreement  # `flips`: what its pieces say of the state itself, along every feature.
    flips: Agreement  # `flips`: the agent, asked at what is reported as a flip, does choose so.
    repeated: Agreement  # Asked again now, the agent still decides as it is recorded.


def measure_faithfulness(
    mind: Mind, spec: TaskSpec, decisions: list[Decision], ranges: Ranges
) -> Faithfulness:
    """Tries every kind of explanation on recorded decisions."""
    counts = {name: [0, 0] for name in ("parts", "lines", "flips", "repeated")}

    def note(name: str, agrees: bool) -> None:
        counts[name][0] += agrees
        counts[name][1] += 1

    for decision in decisions:
        seen = decision.observation
        action = mind.act(seen)
        note("parts", explain_why(decision, spec, mind.view).is_faithful)
        if not decision.explored:
            note("repeated", action == decision.action)
        if mind.is_piecewise_linear:
            for feature in range(len(seen)):
                note("lines", _is_told(mind, seen, feature, ranges, action))
        for both in explain_flips(mind, decision, ranges).features:
            for flip in (both.less, both.more):
                if flip is not None:
                    there = seen.copy()
                    there[both.feature] = flip.beyond
                    note("flips", mind.act(there) == flip.action != action)
    return Faithfulness(**{name: Agreement(*count) for name, count in counts.items()})


def _is_told(
    mind: Mind, seen: NDArray[np.float64], feature: int, ranges: Ranges, action: int
) -> bool:
    """Whether the piece that holds the state, on the line of a feature, tells its action."""
    pieces = scan_line(mind, seen, feature, ranges)
    value = float(seen[feature])
    holding = [piece for piece in pieces if piece.start <= value <= piece.end]
    # Outside of its range, as single precision may put it, no piece is asked.
    return not holding or any(action in piece.actions for piece in holding)
