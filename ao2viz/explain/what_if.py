"""What the agent would do if it saw something else: asked of the mind, never guessed.

A local, counterfactual explanation whose state a person chooses.
"""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.flips import Flips, affordable_steps, explain_flips
from ao2viz.explain.words import amount, number

PATIENCE_S = 1.5
"""Flips that are found by trying may take about so long, where a person waits for them."""


def find_flips_at(
    mind: Mind, state: NDArray[np.float64], ranges: Ranges, patience_s: float = PATIENCE_S
) -> Flips:
    """What would flip the decision at a state [D]; takes some twenty milliseconds.

    Of an agent that thinks ahead, as much as can be tried within a second or two.

    Raises:
        ValueError: If even the fewest steps along each feature take longer.
    """
    steps = affordable_steps(mind, state, patience_s)
    if steps == 0:
        raise ValueError(
            "This agent thinks so far ahead that finding its flips by trying takes too long for "
            "here: every place that is tried takes a plan. ao2viz explain FILE flip asks it."
        )
    return explain_flips(mind, mind.decide(state), ranges, steps)


def tell_certainty(flips: Flips, attention: NDArray[np.float64], spec: TaskSpec) -> str:
    """What is certain around a state, and what that comes to for each feature alone."""
    certificate = flips.certificate
    if certificate is None:
        reason = "several options vote" if flips.decision.plan is None else "it thinks ahead"
        return (
            f"Nothing is certain at a distance: {reason}. The flips were found by trying, in "
            f"{flips.steps} steps each way, and are known to within a millionth of a step; what "
            "changes and changes back within a step was not seen."
        )
    if np.isinf(certificate.radius):
        return "Certain: whatever is seen, no option chooses otherwise."
    if certificate.radius <= 0:
        return "Nothing is certain around here: it is a tie, or the choice is on the edge."
    alone = [
        f"{amount(certificate.radius / float(unit), feature)} of {feature.name}"
        for feature, unit in zip(spec.features, attention, strict=True)
        if unit > 0
    ]
    return (
        f"Certain: within a distance of {number(certificate.radius)} the action stays the same, "
        f"whatever changes. For one feature alone that is {', or '.join(alone)}; if several "
        "change, their shares of it add up."
    )
