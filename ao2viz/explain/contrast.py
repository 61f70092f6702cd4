"""Why not that one: what stood against another action, by how much, and since when.

A local, contrastive explanation ("why this rather than that").
"""

from dataclasses import dataclass

import numpy as np

from ao2viz.core.decision import NO_OPTION, DecideBy, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.why import offset_of
from ao2viz.explain.words import amount, capitalised, count, number, percent, signed, told_apart


@dataclass(frozen=True)
class Against:
    """One option's part in the advantage of the chosen action over the other one."""

    option: int
    share: float
    chosen_weight: float
    other_weight: float
    advantage: float  # Share · (chosen weight − other weight); negative: it spoke for the other.
    chosen_visits: int  # How often the option tried each of the two.
    other_visits: int
    born: int  # The agent's step at which the option was made.


@dataclass(frozen=True)
class Advocate:
    """The most similar option whose own weights prefer the other action."""

    option: int
    distance: float
    nearer: int  # Options that are more similar to what was seen than it.
    advantage: float  # Of the other action over the chosen one, by its own weights.


@dataclass(frozen=True, eq=False)
class WhyNot:
    """Why an action was chosen rather than another; the parts add up to the advantage.

    By path: sum of `against` (one option) + evened + sum of offsets. By vote: the sum of `against`.
    A decision that thought ahead has `by_thinking` besides.
    """

    decision: Decision
    other: int  # The action asked about.
    advantage: float  # What the chosen action was expected to earn more; negative if less.
    against: tuple[Against, ...]  # The strongest first; empty while there was no option.
    evened: float  # By path: what the neighbours of the option add to the advantage.
    offsets: tuple[float, ...]  # [D] by path: what the offset of each feature adds to it.
    by_thinking: float  # What imagining sequences of actions added; 0 without.
    advocate: Advocate | None  # None: no option prefers the other action.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.


def explain_why_not(decision: Decision, other: int, view: ForestView) -> WhyNot:
    """Takes apart what spoke for the chosen action against another.

    Args:
        decision: As recorded.
        other: The index of the other action.
        view: The forest that decided: visits and births are its own.

    Raises:
        ValueError: If there is no such action, or it is the chosen one.
    """
    n_actions, chosen = len(decision.action_values), decision.action
    if not 0 <= other < n_actions or other == chosen:
        raise ValueError(
            f"Expected another action than the chosen one, {chosen}, from 0 to {n_actions - 1}, "
            f"but got {other}."
        )
    outlook, values = decision.outlook_values, decision.action_values
    against = _against(decision, other, view)
    by_outlook = float(outlook[chosen] - outlook[other])
    offsets = np.zeros(len(decision.observation))
    evened = 0.0
    if decision.decide_by is DecideBy.PATH and len(decision.voters):
        offsets = (decision.slopes[chosen] - decision.slopes[other]) * offset_of(decision, view)
        evened = by_outlook - against[0].advantage - float(offsets.sum())
    advantage = float(values[chosen] - values[other])
    return WhyNot(
        decision=decision,
        other=other,
        advantage=advantage,
        against=against,
        evened=evened,
        offsets=tuple(offsets.tolist()),
        by_thinking=advantage - by_outlook,
        advocate=_find_advocate(decision, other, view),
    )


def _against(decision: Decision, other: int, view: ForestView) -> tuple[Against, ...]:
    chosen, found = decision.action, []
    for n, option in enumerate(decision.voters.tolist()):
        weights, share = decision.voter_weights[n], float(decision.shares[n])
        known = option < len(view.born)
        found.append(
            Against(
                option=option,
                share=share,
                chosen_weight=float(weights[chosen]),
                other_weight=float(weights[other]),
                advantage=share * float(weights[chosen] - weights[other]),
                chosen_visits=int(view.visits[option, chosen]) if known else 0,
                other_visits=int(view.visits[option, other]) if known else 0,
                born=int(view.born[option]) if known else NO_OPTION,
            )
        )
    return tuple(sorted(found, key=lambda part: -part.advantage))


def _find_advocate(decision: Decision, other: int, view: ForestView) -> Advocate | None:
    chosen = decision.action
    prefers = view.is_alive & (view.weights[:, other] == view.weights.max(axis=1, initial=-np.inf))
    prefers &= view.weights[:, other] > view.weights[:, chosen]
    if not prefers.any():
        return None
    distances = view.distances_to(decision.observation)
    option = int(np.argmin(np.where(prefers, distances, np.inf)))
    return Advocate(
        option=option,
        distance=float(distances[option]),
        nearer=int(np.count_nonzero(distances < distances[option])),
        advantage=float(view.weights[option, other] - view.weights[option, chosen]),
    )


def tell_why_not(told: WhyNot, spec: TaskSpec) -> str:
    """The explanation in sentences."""
    decision, names = told.decision, spec.action_names
    chosen, other = names[decision.action], names[told.other]
    values = decision.action_values
    if not told.against:
        return f"Nothing stood against {other}: there were no options to ask yet."
    high, low = told_apart(float(values[decision.action]), float(values[told.other]))
    if decision.explored:
        text = f"{capitalised(chosen)} was drawn at random, to explore: nothing stood against "
        text += f"{other}. "
        text += f"Expected were {high} of {chosen} and {low} of {other}."
    elif told.advantage == 0:
        text = f"Both were expected to earn {high}; a toss decided for {chosen}."
    else:
        text = f"{capitalised(other)} was expected to earn {low}, {chosen} {high}: "
        text += f"{number(told.advantage)} more."
    text += f" {_tell_parts(told, spec)}"
    if told.by_thinking:
        text += f" Thinking ahead added {signed(told.by_thinking)} to the difference."
    return f"{text} {_tell_advocate(told, other)}"


def _tell_parts(told: WhyNot, spec: TaskSpec) -> str:
    decision, first = told.decision, told.against[0]
    if decision.decide_by is DecideBy.VOTE:
        those = [part for part in told.against if part.advantage > 0]
        rest = [part for part in told.against if part.advantage < 0]
        text = f"{count(len(those), 'option')} spoke against it and {len(rest):,} for it."
        if those:
            text += f" Option {first.option}, with {percent(first.share)} of the say, weighed the "
            text += f"most: {signed(first.advantage)} of {signed(told.advantage)}."
        return f"{text} {_tell_history(first, decision, told.other, spec)}"
    text = f"Option {first.option} decided: by its own weights the difference is "
    text += signed(first.chosen_weight - first.other_weight)
    if not np.isnan(told.evened) and decision.slopes.any():
        text += f", its neighbours add {signed(told.evened)}"
        for d in np.argsort(-np.abs(told.offsets), kind="stable").tolist():
            feature, part = spec.features[d], told.offsets[d]
            if part:
                text += f", {feature.name} at {amount(float(decision.observation[d]), feature)} "
                text += f"{signed(part)}"
    return f"{text}. {_tell_history(first, decision, told.other, spec)}"


def _tell_history(part: Against, decision: Decision, other: int, spec: TaskSpec) -> str:
    if part.born < 0:
        return f"Option {part.option} is no longer there."
    names = spec.action_names
    return (
        f"It has been there since step {part.born:,}; {names[decision.action]} was tried there "
        f"{count(part.chosen_visits, 'time')}, {names[other]} {count(part.other_visits, 'time')}."
    )


def _tell_advocate(told: WhyNot, other: str) -> str:
    found = told.advocate
    if found is None:
        return f"No option prefers {other} by its own weights."
    if found.nearer == 0:
        return (
            f"By its own weights, option {found.option}, the most similar, prefers {other} by "
            f"{number(found.advantage)}; its outlook says otherwise."
        )
    return (
        f"The most similar option that prefers {other} is {found.option}, at a distance of "
        f"{number(found.distance)}; {count(found.nearer, 'option')} "
        f"{'is' if found.nearer == 1 else 'are'} nearer."
    )
