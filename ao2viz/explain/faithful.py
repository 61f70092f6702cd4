"""Faithfulness: how often an explanation's action is the agent's, counted and not assumed."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.forest import ForestView
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Agreement, Check, Faithfulness
from ao2viz.explain.ahead import look_ahead
from ao2viz.explain.contrast import explain_why_not
from ao2viz.explain.flips import affordable_steps, explain_flips
from ao2viz.explain.line import scan_line
from ao2viz.explain.origin import explain_weight
from ao2viz.explain.radius import certify
from ao2viz.explain.whole import MOST_STATES, Asking
from ao2viz.explain.why import Why, explain_why

MOST_TRIED = 24
"""A check that takes many decisions at each state is tried at so many, spread evenly."""

_DEAR = {Check.LINES, Check.FLIPS, Check.CERTAIN, Check.STORIES}
# Of an agent that thinks ahead flips are found by trying: at fewer states, and not for longer.
_MOST_BRACKETED, _BRACKET_S = 4, 0.3
_AROUND = 8  # Places within each certified radius that are asked.
_NEARLY = 1.0 - 1e-7  # Of the radius: at its very end rounding decides.
_FAR = 100.0  # Where nothing ever changes the action, places within this distance are asked.
# A story comes to its weight but for what its ends have become worth since it was set.
_SINCE = 1e-3

_T = TypeVar("_T")


class Trials:
    """Tries explanations on recorded decisions: each kind once, and only when it is asked for.

    Without recorded decisions those at the options' values stand in for them. It asks the mind, so
    it belongs to the mind's thread.
    """

    def __init__(
        self,
        mind: Mind,
        spec: TaskSpec,
        decisions: Sequence[Decision],
        get_ranges: Callable[[], Ranges],
        most_tried: int = MOST_TRIED,
    ) -> None:
        """Nothing is tried yet.

        Args:
            mind: Whose explanations are tried.
            spec: Its task.
            decisions: Recorded ones.
            get_ranges: What the environment allows; only asked where it matters.
            most_tried: At how many states a check is tried that takes many decisions at each.
        """
        self._mind, self._spec, self._get_ranges = mind, spec, get_ranges
        self._most_tried = most_tried
        self._decisions = decisions
        self._are_recorded = bool(decisions)
        self._known: dict[Check, tuple[Agreement, int]] = {}

    def copy(self, mind: Mind, ranges: Ranges) -> "Trials":
        """The same trials for another thread: with a mind of its own."""
        made = Trials(mind, self._spec, self._decisions, lambda: ranges, self._most_tried)
        made._known = dict(self._known)
        made._are_recorded = self._are_recorded
        return made

    def on(self, checks: Collection[Check], on_progress: Asking | None = None) -> Faithfulness:
        """How often these kinds of explanations agree with the agent.

        Called off by `on_progress`, it tells of what was tried until then.
        """
        if not self._decisions:
            mind = self._mind
            values = spread(list(mind.view.values[mind.view.is_alive]), MOST_STATES)
            self._decisions = [mind.decide(value) for value in values]
        told: dict[Check, tuple[Agreement, int]] = {}
        for check in checks:
            if check in self._known:
                told[check] = self._known[check]
                continue
            report = _part(on_progress, len(told), len(checks))
            told[check], is_whole = self._try(check, report)
            if not is_whole:
                break
            self._known[check] = told[check]
        found = {check.value: agreement for check, (agreement, _) in told.items()}
        states = max((states for _, states in told.values()), default=0)
        return Faithfulness(**found, states=states, are_recorded=self._are_recorded)

    def learned_again(self, other: Mind, states: NDArray[np.float64]) -> Faithfulness:
        """How often a mind that was learned again decides as this one, at states [S, D]."""
        same = [self._mind.act(state) == other.act(state) for state in states]
        found = Agreement(sum(same), len(same))
        return Faithfulness(learned=found, states=len(same), are_recorded=self._are_recorded)

    def _try(self, check: Check, goes_on: Asking) -> tuple[tuple[Agreement, int], bool]:
        """What came of a check and at how many states; and whether all of them were tried."""
        most = self._most_tried if check in _DEAR else MOST_STATES
        if self._mind.thinks_ahead and check is not Check.PARTS:
            # Every decision takes a plan.
            most = _MOST_BRACKETED if check is Check.FLIPS else min(most, MOST_TRIED)
        answers, states, is_whole = [], 0, True
        decisions = spread(self._decisions, most)
        for place, decision in enumerate(decisions):
            if goes_on(place / len(decisions)) is False:
                is_whole = False
                break
            found = _TRIALS[check](self._mind, self._spec, decision, self._get_ranges)
            answers += found
            states += bool(found)
        return (Agreement(sum(answers), len(answers)), states), is_whole


def _part(on_progress: Asking | None, place: int, parts: int) -> Asking:
    """Reports of one of so many equal parts, as a share of all."""
    if on_progress is None:
        return lambda _: True
    return lambda share: on_progress((place + share) / parts)


def spread(items: Sequence[_T], most: int) -> list[_T]:
    """No more than so many of them, spread evenly."""
    if not items:
        return []
    kept = np.unique(np.linspace(0, len(items) - 1, most).astype(np.int64))
    return [items[n] for n in kept.tolist()]


_Trial = Callable[[Mind, TaskSpec, Decision, Callable[[], Ranges]], list[bool]]


def _try_parts(mind: Mind, spec: TaskSpec, decision: Decision, _: object) -> list[bool]:
    why = explain_why(decision, spec, mind.view)
    return [why.is_faithful and _rests_on_plane(mind, why)]


def _rests_on_plane(mind: Mind, why: Why) -> bool:
    """Whether what neighbours and offsets add is what the option's plane says, fitted anew.

    What the neighbours add is told as the rest, so adding up alone would prove little. Where the
    agent has learned more since, the plane is no longer that of the decision, and is not asked.
    """
    decision = why.decision
    if decision.decide_by is DecideBy.VOTE or len(decision.voters) == 0:
        return True
    option = int(decision.voters[0])
    again = mind.decide(decision.observation)
    is_as_it_was = np.array_equal(again.voters, decision.voters) and np.array_equal(
        again.slopes, decision.slopes
    )
    if np.isnan(why.offset).any() or not is_as_it_was:
        return True
    (levels,), (slopes,) = mind.planes([option])
    evened = levels - mind.view.weights[option]
    added = slopes @ (mind.view.attention * why.offset)
    scale = 1.0 + np.abs(levels).max()
    told = [(part.evened, sum(part.offsets)) for part in why.weighings]
    return bool(np.allclose(np.column_stack([evened, added]), told, rtol=0, atol=1e-9 * scale))


def _try_contrasts(mind: Mind, _: object, decision: Decision, __: object) -> list[bool]:
    if len(decision.voters) == 0 or len(decision.action_values) < 2:
        return []
    return [check_contrast(decision, decision.runner_up_action, mind.view)]


def check_contrast(decision: Decision, other: int, view: ForestView) -> bool:
    """Whether the parts of the difference between two actions add up to it, and to the choice."""
    why_not = explain_why_not(decision, other, view)
    offset = np.nan_to_num(np.array(why_not.offsets)).sum()
    evened = 0.0 if np.isnan(why_not.evened) else why_not.evened
    spoken = sum(part.advantage for part in why_not.against)
    total = spoken + evened + offset + why_not.by_thinking
    adds_up = np.isclose(total, why_not.advantage, rtol=1e-9, atol=1e-12)
    is_own_choice = decision.explored or why_not.advantage >= 0
    return bool((adds_up or np.isnan(why_not.evened)) and is_own_choice)


def _try_lines(
    mind: Mind, _: object, decision: Decision, get_ranges: Callable[[], Ranges]
) -> list[bool]:
    if not mind.is_piecewise_linear:
        return []
    seen, ranges = decision.observation, get_ranges()
    action = mind.act(seen)
    return [_is_told(mind, seen, feature, ranges, action) for feature in range(len(seen))]


def _is_told(
    mind: Mind, seen: NDArray[np.float64], feature: int, ranges: Ranges, action: int
) -> bool:
    """Whether the piece that holds the state, on the line of a feature, tells its action."""
    pieces = scan_line(mind, seen, feature, ranges)
    value = float(seen[feature])
    holding = [piece for piece in pieces if piece.start <= value <= piece.end]
    # Outside of its range, as single precision may put it, no piece is asked.
    return not holding or any(action in piece.actions for piece in holding)


def _try_flips(
    mind: Mind, _: object, decision: Decision, get_ranges: Callable[[], Ranges]
) -> list[bool]:
    seen = decision.observation
    action, steps = mind.act(seen), affordable_steps(mind, seen, _BRACKET_S)
    if steps == 0:
        return []
    answers = []
    for both in explain_flips(mind, decision, get_ranges(), steps).features:
        for flip in (both.less, both.more):
            if flip is not None:
                there = seen.copy()
                there[both.feature] = flip.beyond
                answers.append(mind.act(there) == flip.action != action)
    return answers


def _try_certain(mind: Mind, _: object, decision: Decision, __: object) -> list[bool]:
    if not mind.is_piecewise_linear:
        return []
    seen, attention = decision.observation, mind.view.attention
    radius = min(certify(mind, seen).radius, _FAR)
    if radius <= 0:
        return []
    action = mind.act(seen)
    # Drawn from the state's own bits: the same agent is always tried at the same places.
    rng = np.random.default_rng(np.frombuffer(seen.tobytes(), np.uint32))
    answers = []
    for n in range(_AROUND):
        parts = rng.exponential(size=len(seen))
        if n % 2:  # Along one axis: the corners of what is certain are where it would break.
            parts[np.argsort(parts)[:-1]] = 0.0
        steps = radius * _NEARLY * rng.choice((-1.0, 1.0), len(seen)) * parts / parts.sum()
        moved = np.divide(steps, attention, out=np.zeros_like(steps), where=attention > 0)
        answers.append(mind.act(seen + moved) == action)
    return answers


def _try_ways(mind: Mind, _: object, decision: Decision, __: object) -> list[bool]:
    if mind.known is None:
        return []
    way = look_ahead(mind, decision.observation, 1)
    return [step.action == mind.act(decision.observation) for step in way.steps]


def _try_stories(mind: Mind, _: object, decision: Decision, __: object) -> list[bool]:
    if mind.known is None or len(decision.voters) == 0:
        return []
    option = int(decision.voters[0])
    if not (option < len(mind.view.is_alive) and mind.view.is_alive[option]):
        return []
    origin = explain_weight(mind, option, decision.action)
    return [bool(np.isclose(origin.explained, origin.weight, rtol=_SINCE))]


def _try_distances(mind: Mind, _: object, decision: Decision, __: object) -> list[bool]:
    if len(mind.view) == 0:
        return []
    seen = decision.observation
    told = float(mind.view.distances_to(seen)[mind.view.is_alive].min())
    return [bool(np.isclose(mind.decide(seen).distance, told, rtol=1e-9, atol=1e-12))]


def _try_again(mind: Mind, _: object, decision: Decision, __: object) -> list[bool]:
    return [] if decision.explored else [mind.act(decision.observation) == decision.action]


_TRIALS: Mapping[Check, _Trial] = {
    Check.PARTS: _try_parts,
    Check.CONTRASTS: _try_contrasts,
    Check.LINES: _try_lines,
    Check.FLIPS: _try_flips,
    Check.CERTAIN: _try_certain,
    Check.WAYS: _try_ways,
    Check.STORIES: _try_stories,
    Check.DISTANCES: _try_distances,
    Check.REPEATED: _try_again,
}
