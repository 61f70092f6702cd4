"""Why this action: what was compared, what each action was expected to earn, and from what.

A local, factual explanation. Everything comes from the recorded decision; the forest only adds
the options' values, by which what each feature's offset adds is told apart.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.sentence import Explanation, PathStep, explain, path_steps
from ao2viz.explain.words import amount, capitalised, number, signed


@dataclass(frozen=True)
class Weighing:
    """What one action was expected to earn, in parts that add up to it.

    Of a decision by path: own + evened + sum of offsets = outlook. By vote the options that spoke
    are the parts: own is the outlook, and the offsets are empty.
    """

    action: int
    total: float  # What decided; differs from `outlook` only where it thought ahead.
    outlook: float
    own: float  # By path: the deciding option's own weight.
    evened: float  # What its neighbours add to that at the option's value.
    offsets: tuple[float, ...]  # [D] what each feature's offset from the option's value adds.


@dataclass(frozen=True)
class Voter:
    """One option that spoke."""

    option: int
    share: float
    distance: float
    weights: tuple[float, ...]  # [A]
    path: tuple[PathStep, ...]  # Root first, with every distance by feature.


@dataclass(frozen=True, eq=False)
class Why:
    """Why an action was chosen."""

    decision: Decision
    explanation: Explanation  # In sentences.
    voters: tuple[Voter, ...]  # The most similar first.
    weighings: tuple[Weighing, ...]  # [A]
    offset: NDArray[np.float64]  # [D] from the deciding option's value; NaN: unknown, or a vote.
    runner_up_gap: float  # How much less similar the second option is, as distance; NaN: none.
    is_faithful: bool
    """Whether the parts choose what the agent chose; an action drawn at random they cannot."""
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.


def explain_why(decision: Decision, spec: TaskSpec, view: ForestView) -> Why:
    """Takes a decision apart.

    Args:
        decision: As recorded.
        spec: Names actions and features.
        view: The forest that decided. Of one that has changed since, distances by feature and
            offsets are told only where they still hold.
    """
    voters = tuple(
        Voter(
            option=int(option),
            share=float(decision.shares[n]),
            distance=float(decision.path_distances[n, len(decision.path_of(n)) - 1]),
            weights=tuple(decision.voter_weights[n].tolist()),
            path=path_steps(decision, spec, view, n),
        )
        for n, option in enumerate(decision.voters)
    )
    offset = offset_of(decision, view)
    weighings = _weigh(decision, offset)
    return Why(
        decision=decision,
        explanation=explain(decision, spec, view),
        voters=voters,
        weighings=weighings,
        offset=offset,
        runner_up_gap=decision.runner_up_distance - decision.distance,
        is_faithful=_is_faithful(decision, weighings),
    )


def offset_of(decision: Decision, view: ForestView) -> NDArray[np.float64]:
    """[D] from the deciding option's value to what was seen; NaN by vote, or if it is gone."""
    unknown = np.full(len(decision.observation), np.nan)
    if decision.decide_by is DecideBy.VOTE or len(decision.voters) == 0:
        return unknown
    option = int(decision.voters[0])
    if option >= len(view.is_alive) or not view.is_alive[option]:
        return unknown
    return decision.observation - view.values[option]


def _weigh(decision: Decision, offset: NDArray[np.float64]) -> tuple[Weighing, ...]:
    outlook, totals = decision.outlook_values, decision.action_values
    by_path = decision.decide_by is DecideBy.PATH and len(decision.voters) > 0
    own = decision.voter_weights[0] if by_path else outlook
    offsets = decision.slopes * offset if by_path else np.empty((len(outlook), 0))
    evened = outlook - own - offsets.sum(axis=1)
    return tuple(
        Weighing(
            action=a,
            total=float(totals[a]),
            outlook=float(outlook[a]),
            own=float(own[a]),
            evened=float(evened[a]),
            offsets=tuple(offsets[a].tolist()),
        )
        for a in range(len(outlook))
    )


def _is_faithful(decision: Decision, weighings: tuple[Weighing, ...]) -> bool:
    """Whether the parts, added up anew, give what the record says, and so its choice."""
    if decision.decide_by is DecideBy.VOTE and len(decision.voters):
        again = decision.shares @ decision.voter_weights
        if not np.allclose(again, decision.outlook_values, rtol=1e-9, atol=1e-12):
            return False
    best = max(part.total for part in weighings)
    chosen = decision.explored or weighings[decision.action].total == best
    tied = sum(part.total == best for part in weighings) > 1
    return chosen and tied == decision.is_tie


def tell_why(why: Why, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences: the choice, its path, and what each action's worth is of."""
    lines = [f"{capitalised(why.explanation.headline)}. {why.explanation.reason}"]
    if why.voters:
        path = why.voters[0].path
        told = ", then ".join(f"{step.option} ({number(step.distance)})" for step in path)
        text = f"The path, with distances: {told}."
        if not np.isnan(why.runner_up_gap):
            text += f" The next most similar, {why.decision.runner_up_option}, is "
            text += f"{number(why.runner_up_gap)} further away."
        lines.append(text)
    order = np.argsort([-part.total for part in why.weighings], kind="stable")
    lines += [tell_parts(why, spec, int(a)) for a in order]
    return tuple(lines)


def tell_parts(why: Why, spec: TaskSpec, action: int) -> str:
    """One sentence: what the expectation of an action is made of."""
    part, names = why.weighings[action], spec.action_names
    decision = why.decision
    if len(decision.voters) == 0:
        return f"{capitalised(names[action])}: nothing is known."
    if decision.decide_by is DecideBy.VOTE:
        loudest = sorted(why.voters, key=lambda voter: -voter.share)[:3]
        said = ", ".join(
            f"option {v.option} {number(v.share * v.weights[action])} "
            f"({number(v.share)} of {number(v.weights[action])})"
            for v in loudest
        )
        return (
            f"{capitalised(names[action])}: {number(part.outlook)} in all, most of it from {said}."
        )
    if np.isnan(part.evened):
        return (
            f"{capitalised(names[action])}: {number(part.outlook)}; its option is no longer there."
        )
    text = f"{capitalised(names[action])}: the option's own weight {number(part.own, 5)}"
    if decision.slopes.any() or part.evened:
        text += f", {signed(part.evened)} from its neighbours"
        for d in np.argsort(-np.abs(part.offsets), kind="stable").tolist():
            if part.offsets[d]:
                text += f", {signed(part.offsets[d])} for {_offset(float(why.offset[d]), spec, d)}"
    return f"{text}: {number(part.outlook, 5)}."


def _offset(gap: float, spec: TaskSpec, d: int) -> str:
    feature = spec.features[d]
    return f"{amount(abs(gap), feature)} {'more' if gap > 0 else 'less'} {feature.name}"
