"""Why the agent did what it did, in words: recorded numbers formatted, nothing guessed.

Rule: every number in a sentence is in the Decision, or is computed from it and the forest in a
way that the sentence names. Ties and exploration are said first, because then the numbers are not
the reason.
"""

from dataclasses import dataclass

import numpy as np

from ao2viz.core.decision import NO_OPTION, DecideBy, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.catalogue import Feature
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import amount, capitalised, count, number, percent, told_apart


@dataclass(frozen=True)
class Explanation:
    """A decision in words."""

    headline: str  # What it did: "push right".
    reason: str  # One or two sentences.
    marks: tuple[str, ...]  # Short remarks: "explored", "tie", "new option 12", "close call", …


@dataclass(frozen=True)
class Gap:
    """One feature of the comparison between what was seen and an option's value."""

    feature: str
    seen: str
    known: str  # The option's value.
    share: float  # Of the distance, in [0, 1]; NaN if attention has changed since.


@dataclass(frozen=True)
class PathStep:
    """One option on the way from the root to the most similar option."""

    option: int
    distance: float
    gaps: tuple[Gap, ...]  # The biggest first; empty if the forest no longer holds the option.


CLOSE_CALL = 0.001
"""A margin below this share of the expected return is called close."""


def explain(decision: Decision, spec: TaskSpec, view: ForestView | None = None) -> Explanation:
    """Says what was done and why.

    Args:
        decision: As recorded.
        spec: Names actions and features.
        view: The forest, if at hand: adds where the most similar option differs the most.
    """
    action = spec.action_names[decision.action]
    marks = []
    if decision.explored:
        marks.append("explored")
    if decision.is_tie and len(decision.voters):
        marks.append("tie")
    if decision.created != NO_OPTION:
        marks.append(f"new option {decision.created}")
    if len(decision.voters) == 0:
        how = "it was drawn at random" if decision.explored else "nothing spoke for another action"
        return Explanation(action, f"There were no options to ask yet, so {how}.", tuple(marks))
    if is_close(decision):
        marks.append("close call")
    if _changed_its_mind(decision):
        marks.append("changed its mind")
    reason = f"{_main_clause(decision, spec)} {_whom(decision, spec, view)}"
    if decision.created != NO_OPTION:
        reason += f" What was seen was new enough for an option of its own: {decision.created}."
    return Explanation(action, reason, tuple(marks))


def path_steps(
    decision: Decision, spec: TaskSpec, view: ForestView | None = None, voter: int = 0
) -> tuple[PathStep, ...]:
    """The path to a voter, root first, with what was compared at every option."""
    if len(decision.voters) == 0:
        return ()
    path = decision.path_of(voter)
    distances = decision.path_distances[voter, : len(path)]
    return tuple(
        PathStep(
            int(option),
            float(distance),
            _gaps(int(option), float(distance), decision, spec, view),
        )
        for option, distance in zip(path, distances, strict=True)
    )


def _main_clause(decision: Decision, spec: TaskSpec) -> str:
    values = decision.action_values
    chosen, best = decision.action, decision.best_action
    names = spec.action_names
    if decision.explored:
        text = f"Exploring: {names[chosen]} was drawn at random"
        if decision.is_tie:
            return (
                f"{text}; several actions were expected to earn the same, {number(values[best])}."
            )
        if chosen == best:
            return f"{text}; it also was expected to earn the most, {number(values[best])}."
        low, high = told_apart(float(values[chosen]), float(values[best]))
        return (
            f"{text}. {capitalised(names[best])} was expected to earn more: {high} against {low}."
        )
    if decision.is_tie:
        tied = [names[i] for i in np.flatnonzero(values == values[best])]
        tie = f"A tie: {_listed(tied)} were expected to earn exactly {number(values[best])}."
        return tie if decision.plan is None else f"{tie} {_plan_clause(decision, spec)}."
    if decision.plan is not None:
        return _thinking(decision, spec)
    if len(values) == 1:
        return f"The only action, expected to earn {number(values[chosen])}."
    other = decision.runner_up_action
    high, low = told_apart(float(values[chosen]), float(values[other]))
    more = number(decision.margin)
    return f"Expected to earn {high} against {low} for {names[other]}: {more} more."


def _thinking(decision: Decision, spec: TaskSpec) -> str:
    """What the plan is expected to earn, beside the best that begins otherwise."""
    values, before, names = decision.action_values, decision.outlook_values, spec.action_names
    chosen, other = decision.action, decision.runner_up_action
    high, low = told_apart(float(values[chosen]), float(values[other]))
    text = _plan_clause(decision, spec)
    if decision.plan is not None and len(decision.plan.actions):
        text += f", in all {high}"
    else:
        text += f", and the options expect it to earn {high}"
    text += " (discounted)"
    if chosen != other:
        text += f" against {low} when beginning with {names[other]}"
    if _changed_its_mind(decision):
        best = int(np.argmax(before))
        high, low = told_apart(float(before[best]), float(before[chosen]))
        text += f". Without thinking, {names[best]} was expected to earn more: {high} against {low}"
    return f"{text}."


def _plan_clause(decision: Decision, spec: TaskSpec) -> str:
    plan = decision.plan
    assert plan is not None
    names = [spec.action_names[a] for a in plan.actions]
    if not names:
        return f"Thinking ahead: what follows {spec.action_names[decision.action]} is unknown"
    rewards = ", ".join(number(float(reward)) for reward in plan.rewards)
    text = f"Thinking {count(len(names), 'step')} ahead: {', '.join(names)} "
    text += f"is expected to earn {rewards} and "
    goes_on = float(plan.continues[-1])
    if goes_on == 0:
        return f"{text}end the episode"
    text += f"lead near option {int(plan.options[-1])}, worth {number(plan.worth)}"
    if goes_on < 1:
        text += f" (a chance of {percent(1 - goes_on)} that the episode ends on the way)"
    return text


def _changed_its_mind(decision: Decision) -> bool:
    before = decision.outlook_values
    return decision.plan is not None and bool(before[decision.action] < before.max())


def _whom(decision: Decision, spec: TaskSpec, view: ForestView | None) -> str:
    first = int(decision.voters[0])
    if decision.plan is not None:
        text = f"Option {first} is the most similar now"
    elif decision.decide_by is DecideBy.PATH:
        text = f"Option {first}, the most similar, decided alone"
        if decision.slopes.any():
            text += f": {_outlook(decision, spec)}"
    elif len(decision.voters) == 1:
        text = f"Option {first} was the only one to vote"
    else:
        share, loudest = percent(float(decision.shares[0])), int(np.argmax(decision.shares))
        text = f"{count(len(decision.voters), 'option')} voted; the most similar, {first}, had "
        most = percent(float(decision.shares[loudest]))
        if loudest == 0:
            text += f"the most say: {share}"
        else:
            text += f"{share} of the say"
            if most != share:
                text += f", {int(decision.voters[loudest])} the most: {most}"
    gaps = _gaps(first, decision.distance, decision, spec, view)
    if not gaps:
        return f"{text}."
    if decision.distance == 0:
        return f"{text}. It stands for exactly what was seen."
    gap = gaps[0]
    seen, known = gap.seen, gap.known
    if seen == known:
        return f"{text}. It stands for almost exactly what was seen."
    return f"{text}. It differs most in {gap.feature}: {known} there, {seen} now."


def _outlook(decision: Decision, spec: TaskSpec) -> str:
    """How the option's own weights and its outlook differ."""
    names, best = spec.action_names, decision.best_action
    weights = decision.voter_weights[0]
    own, here = told_apart(float(weights[best]), float(decision.action_values[best]))
    text = f"its own weight for {names[best]} is {own}, its outlook here {here}"
    preferred = int(np.argmax(weights))
    if weights[preferred] > weights[best]:
        text += f" (by its own weights it prefers {names[preferred]})"
    return text


def _gaps(
    option: int, distance: float, decision: Decision, spec: TaskSpec, view: ForestView | None
) -> tuple[Gap, ...]:
    if view is None or not (0 <= option < len(view.parents)) or not view.is_alive[option]:
        return ()
    parts = view.attention * np.abs(decision.observation - view.values[option])
    total = float(parts.sum())
    # Attention is learned: after it changed, today's parts no longer add up to that distance.
    holds = np.isclose(total, distance, rtol=1e-6, atol=1e-12)
    shares = parts / total if holds and total > 0 else np.full(len(parts), np.nan)
    order = np.argsort(-parts, kind="stable")
    return tuple(
        _gap(
            spec.features[i],
            float(decision.observation[i]),
            float(view.values[option, i]),
            float(shares[i]),
        )
        for i in order
    )


def _gap(feature: Feature, seen: float, known: float, share: float) -> Gap:
    return Gap(feature.name, amount(seen, feature), amount(known, feature), share)


def is_close(decision: Decision) -> bool:
    """Whether it was a close call: chosen, not drawn or tied, by less than `CLOSE_CALL`."""
    if decision.explored or decision.is_tie or len(decision.action_values) < 2:
        return False
    scale = float(np.abs(decision.action_values).max())
    return 0 <= decision.margin < CLOSE_CALL * scale


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
