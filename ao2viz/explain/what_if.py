"""What the agent would do if it saw something else: asked of the mind, never guessed.

A local, counterfactual explanation whose state a person chooses.
"""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import Decision
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.faithful import Faithfulness, measure_faithfulness
from ao2viz.explain.flips import Flips, explain_flips
from ao2viz.explain.radius import Certificate
from ao2viz.explain.words import amount, number

MOST_TRIED = 24
"""Explanations of so many recorded decisions are tried to say how faithful they are."""


def find_flips_at(mind: Mind, state: NDArray[np.float64], ranges: Ranges) -> Flips:
    """What would flip the decision at a state [D]; takes some twenty milliseconds.

    Raises:
        ValueError: If the agent thinks ahead: then every place that is tried takes a plan.
    """
    if mind.thinks_ahead:
        raise ValueError(
            "This agent thinks ahead, so every place that is tried takes a plan; that is too slow "
            "for here. ao2viz explain FILE flip asks it."
        )
    return explain_flips(mind, mind.decide(state), ranges)


def try_explanations(
    mind: Mind, spec: TaskSpec, decisions: list[Decision], ranges: Ranges
) -> Faithfulness:
    """How often explanations agree with the agent, on recorded decisions spread evenly.

    Raises:
        ValueError: If the agent thinks ahead, or nothing is recorded.
    """
    if mind.thinks_ahead or not decisions:
        raise ValueError("Nothing is recorded that explanations could be tried on quickly.")
    kept = np.unique(np.linspace(0, len(decisions) - 1, MOST_TRIED).astype(np.int64))
    return measure_faithfulness(mind, spec, [decisions[n] for n in kept], ranges)


def tell_certificate(
    certificate: Certificate | None, attention: NDArray[np.float64], spec: TaskSpec
) -> str:
    """What is certain around a state, and what that comes to for each feature alone."""
    if certificate is None:
        return (
            "Nothing is certain at a distance: several options vote. The flips were found by "
            "trying, step by step; what changes and changes back within a step was not seen."
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
