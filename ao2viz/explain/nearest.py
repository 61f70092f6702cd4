"""The nearest flip of all features at once: the least change that changes the action.

Least in weighted L1, where one option decides by its plane; exact up to a gap that is told. The
action differs exactly where some option j is the most similar and expects more of some action b
than of the one chosen here. For one pair (j, b) that is a mixed-integer linear program over the
change y: minimise Σ|y|, such that j's plane gives b no less, and for every other option k the
distance to j is no greater than that to k. |y − c_j| may be bounded from above by linear terms;
|y − c_k| from below needs to know on which side of c_k the change ends, one binary for a feature
where both are within reach. Most options k never matter, so they are added lazily: a program is
solved, the most similar options where it ends are added, and it is solved again.

The pairs are taken best-first, by a lower bound of what each can come to: first that of
`radius` (entered and turned), then that of their program. When the least bound of all has reached
the best flip found, that one is the nearest.
"""

import heapq
import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.flips import find_flips
from ao2viz.explain.program import Program, Solution
from ao2viz.explain.radius import certify, turning_points
from ao2viz.explain.words import amount, capitalised, number, percent
from ao2viz.extras import need


@dataclass(frozen=True, eq=False)
class NearestFlip:
    """The nearest flip as far as the search has come."""

    seen: NDArray[np.float64]  # [D] what was asked about.
    flipped: NDArray[np.float64] | None  # [D] the agent, asked there, chooses otherwise.
    action: int  # What it chooses there; the chosen action itself while none is found.
    distance: float  # To `flipped`, in weighted L1; inf: none is found.
    bound: float  # No observation that the ranges allow and that is nearer changes the action.
    solved: int  # Programs solved so far.
    waiting: int  # Pairs of option and action that may still hold a nearer one.
    is_complete: bool  # The search has ended; else it was cut short.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.

    @property
    def gap(self) -> float:
        """How much nearer, as a part of the distance, another flip may still be; 0: none is."""
        if not np.isfinite(self.distance):
            return 0.0 if self.is_complete else 1.0
        if self.is_complete and self.bound == 0.0:
            return 0.0  # On the very edge.
        return max(0.0, 1.0 - self.bound / self.distance) if self.distance > 0 else 0.0


Progress = Callable[[NearestFlip], bool | None]
"""Called as the search goes on; returning False ends it."""

TOLERANCE = 1e-4
"""The search is complete when the gap is no greater."""

# The solver keeps its constraints to about a millionth; so what it says is least may be too great.
_SOLVER = 1e-5
# Lazily added options at a time, and how much nearer one must be to count as left out.
_ADDED, _VIOLATED = 3, 1e-7
# Of distances, compared with what they are made of.
_ROUNDING = 1e-12
# A flip on the very border is no flip yet: how far inside to look for one, in parts of the reach.
_MARGIN = 1e-5


def find_nearest_flip(
    mind: Mind,
    observation: NDArray[np.float64],
    ranges: Ranges,
    time_limit_s: float = 30.0,
    on_progress: Progress | None = None,
) -> NearestFlip:
    """Searches until the nearest flip is known, the time is up, or `on_progress` ends it.

    Raises:
        ValueError: If the mind does not decide by one option's plane, or there is no SciPy.
    """
    need("explain")
    search = _Search(mind, observation, ranges, time.monotonic() + time_limit_s)
    while search.waiting and not search.is_over():
        if on_progress is not None and on_progress(search.result(is_complete=False)) is False:
            return search.result(is_complete=search.is_settled())
        search.advance()
    result = search.result(is_complete=search.is_settled())
    if on_progress is not None:
        on_progress(result)
    return result


@dataclass(frozen=True)
class _Pair:
    """One option and the action that is to overtake there, with the options it was held against."""

    option: int
    action: int
    against: tuple[int, ...] = ()
    margin: float = 0.0  # By how much it is to be nearer, and expect more.


class _Search:
    """The state of a search: the best flip so far and the pairs still to be looked at.

    Changes are in units of `reach`, scaled by attention: every number the solver sees is about 1.
    """

    def __init__(
        self, mind: Mind, observation: NDArray[np.float64], ranges: Ranges, deadline: float
    ) -> None:
        self._mind, self._seen, self._deadline = mind, observation, deadline
        self._attention = mind.view.attention
        self._query = self._attention * observation
        self._ranges = ranges
        self._action = mind.act(observation)
        self._best: NDArray[np.float64] | None = None
        self._distance = np.inf
        self._certain = certify(mind, observation).radius
        self._given_up = np.inf  # Least bound of what could not be settled.
        self._order = itertools.count()
        self.solved = 0
        distances = mind.view.distances_to(observation)
        nearest = float(distances.min(initial=np.inf))
        self._edge = _ROUNDING * (float(np.abs(self._query).sum()) + nearest)
        self._start()
        alive = np.flatnonzero(mind.view.is_alive)
        far = float(distances[alive].max(initial=0.0))
        self.reach = self._distance if np.isfinite(self._distance) else 2.0 * max(far, 1.0)
        self.waiting: list[tuple[float, int, _Pair]] = []
        if self._distance > self._edge:
            self._fill(distances, alive)

    def _start(self) -> None:
        """Finds a first flip: that of a single feature, or an option's value that chooses so."""
        decision = self._mind.decide(self._seen)
        for both in find_flips(self._mind, decision, self._ranges):
            for flip in (both.less, both.more):
                if flip is not None and flip.distance < self._distance:
                    there = self._seen.copy()
                    there[both.feature] = flip.beyond
                    self._offer(there)
        distances = self._mind.view.distances_to(self._seen)
        for option in np.argsort(distances, kind="stable").tolist():
            if distances[option] >= self._distance or not self._mind.view.is_alive[option]:
                break
            value = self._mind.view.values[option]
            if self._ranges.allow(value) and self._offer(value):
                break

    def _offer(self, there: NDArray[np.float64]) -> bool:
        """Takes an observation for the best one, if it flips and is nearer."""
        distance = float(np.abs(self._attention * there - self._query).sum())
        if distance >= self._distance or not self._ranges.allow(there):
            return False
        if self._mind.act(there) == self._action:
            return False
        self._best, self._distance = there.copy(), distance
        return True

    def _fill(self, distances: NDArray[np.float64], alive: NDArray[np.int64]) -> None:
        """Puts every pair that can hold a nearer flip into the queue, by its first bound."""
        entered = (distances[alive] - distances[alive].min(initial=np.inf)) / 2
        near = entered < min(self._distance, self.reach)
        options, entered = alive[near], entered[near]
        for action in range(self._mind.forest.n_actions):
            if action == self._action:
                continue
            turned = turning_points(self._mind, self._seen, self._action, options, action)
            bounds = np.maximum(entered, turned)
            for option, bound in zip(options.tolist(), bounds.tolist(), strict=True):
                self._push(bound, _Pair(option, action))

    def _push(self, bound: float, pair: _Pair) -> None:
        if bound < min(self._distance, self.reach):
            heapq.heappush(self.waiting, (bound, next(self._order), pair))

    def is_over(self) -> bool:
        """Whether time is up, or nothing that waits can matter."""
        return time.monotonic() >= self._deadline or self._bound() >= self._enough()

    def is_settled(self) -> bool:
        """Whether the bound has reached the best flip, or everything was looked at."""
        return self._bound() >= self._enough() or not (self.waiting or np.isfinite(self._given_up))

    def _enough(self) -> float:
        # On the very edge, where only rounding decides, there is nothing to search.
        return -np.inf if self._distance <= self._edge else self._distance * (1.0 - TOLERANCE)

    def _bound(self) -> float:
        least = self.waiting[0][0] if self.waiting else np.inf
        found = 0.0 if self._distance <= self._edge else self._distance
        return max(self._certain, min(least, self._given_up, found, self.reach))

    def result(self, *, is_complete: bool) -> NearestFlip:
        """What is known now."""
        there = self._best
        return NearestFlip(
            seen=self._seen,
            flipped=there,
            action=self._action if there is None else self._mind.act(there),
            distance=self._distance,
            bound=self._bound(),
            solved=self.solved,
            waiting=len(self.waiting),
            is_complete=is_complete,
        )

    def advance(self) -> None:
        """Solves the program of the most promising pair, and draws the conclusions."""
        bound, _, pair = heapq.heappop(self.waiting)
        solution = self._solve(pair)
        if solution is None:
            return
        bound = max(bound, solution.bound * self.reach * (1.0 - _SOLVER))
        if not solution.is_optimal:
            # Time is up in the middle of it.
            self._push(bound, pair)
            return
        there = self._unscale(solution.change)
        self._offer(there)
        distances = self._mind.view.distances_to(there)
        nearer = np.flatnonzero(distances < distances[pair.option] - _VIOLATED * self.reach)
        nearer = nearer[np.argsort(distances[nearer], kind="stable")][:_ADDED]
        new = tuple(k for k in nearer.tolist() if k not in pair.against)
        if new:
            self._push(bound, replace(pair, against=(*pair.against, *new)))
        elif self._distance * (1.0 - TOLERANCE) <= bound:
            pass  # It flips there, and nowhere nearer.
        elif pair.margin == 0.0:
            self._push(bound, replace(pair, margin=_MARGIN))
        else:
            self._given_up = min(self._given_up, bound)

    def _unscale(self, change: NDArray[np.float64]) -> NDArray[np.float64]:
        """The observation that a change, in units of `reach`, leads to; kept within the ranges."""
        steps = np.divide(
            change * self.reach,
            self._attention,
            out=np.zeros_like(change),
            where=self._attention > 0,
        )
        return np.clip(self._seen + steps, self._ranges.low, self._ranges.high)

    def _solve(self, pair: _Pair) -> Solution | None:
        """Solves a pair's program; None if nothing meets it."""
        self.solved += 1
        mind, chosen = self._mind, self._action
        tips = (mind.forest.columns.scaled - self._query[None, :])[
            [pair.option, *pair.against]
        ] / self.reach
        (levels,), (slopes,) = mind.planes([pair.option])
        lead = levels[pair.action] - levels[chosen]
        tilt = slopes[pair.action] - slopes[chosen]
        lead -= float(tilt @ tips[0]) * self.reach
        furthest = min(self._distance, self.reach) / self.reach
        with np.errstate(invalid="ignore"):
            low = (self._attention * self._ranges.low - self._query) / self.reach
            high = (self._attention * self._ranges.high - self._query) / self.reach
        still = self._attention == 0
        low = np.where(still, 0.0, np.maximum(np.minimum(low, 0.0), -furthest))
        high = np.where(still, 0.0, np.minimum(np.maximum(high, 0.0), furthest))
        program = Program(low, high, furthest)
        steepest = float(np.abs(tilt).max()) * self.reach
        if steepest > 0:
            program.keep_above(tilt * self.reach / steepest, -lead / steepest + pair.margin)
        elif lead < 0:
            return None
        program.stay_near(tips[0], tips[1:], 2.0 * pair.margin)
        return program.solve(max(0.1, self._deadline - time.monotonic()))


def tell_nearest(found: NearestFlip, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences."""
    if found.flipped is None:
        if np.isinf(found.bound):
            return ("Whatever is seen, no option chooses otherwise.",)
        least = f"Nothing nearer than a distance of {number(found.bound)} changes the action"
        return (f"{least}; no change that does was found.",)
    changes = []
    for d, feature in enumerate(spec.features):
        change = float(found.flipped[d] - found.seen[d])
        if change:
            word = "more" if change > 0 else "less"
            changes.append(f"{amount(abs(change), feature)} {word} {feature.name}")
    text = f"{capitalised(', '.join(changes))}: then it chooses {spec.action_names[found.action]}. "
    text += f"That is a distance of {number(found.distance)}"
    if found.is_complete:
        return (f"{text}, the least there is.",)
    return (f"{text}; another flip may be nearer by up to {percent(found.gap)}.",)
