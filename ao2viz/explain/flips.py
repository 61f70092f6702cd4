"""What would flip it: for each feature the nearest values at which the agent chooses otherwise.

A local, counterfactual explanation: "had the pole leaned 0.4° further left, it would have pushed
left". Exact where one option decides by its plane; a vote, or thinking ahead, is bracketed.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.line import Piece, scan_line
from ao2viz.explain.radius import Certificate, certify
from ao2viz.explain.words import amount, capitalised, number


class FlipKind(Enum):
    """What happens at a flip."""

    BORDER = "border"
    """Another option becomes the most similar, and it chooses otherwise."""
    CROSSING = "crossing"
    """The same option decides, and by its outlook another action overtakes."""
    TIE = "tie"
    """From here on several actions are expected to earn exactly the same: a toss decides."""
    BRACKETED = "bracketed"
    """Found by trying: the choice changes within the tolerance, for whatever reason."""


@dataclass(frozen=True)
class Flip:
    """The nearest change of one feature, in one direction, that changes the action."""

    feature: int
    kind: FlipKind
    border: float  # Environment units: up to here the action stays the same.
    beyond: float  # Just beyond: the agent was asked there, and chose otherwise.
    change: float  # border − observed; negative: less.
    distance: float  # The change as weighted distance.
    action: int  # What it chooses just beyond.
    option: int  # Who is the most similar there.
    tolerance: float  # 0: exact, but for rounding; else the border lies within so much of it.
    is_familiar: bool  # Whether some option's value is at least as far out in this feature.


@dataclass(frozen=True)
class FeatureFlips:
    """Both directions of one feature; None: nothing within its range changes the action."""

    feature: int
    low: float  # The range that was looked through.
    high: float
    less: Flip | None
    more: Flip | None


# How far to go into a piece for a place where the agent, asked, agrees: doubled from here.
_FIRST_STEP = 4 * np.finfo(np.float64).eps
# Where a toss decides, so many places are asked for one where it falls otherwise.
_TOSSES = 64
STEPS = 200
"""Where flips are found by trying: so many steps each way along a feature."""

# What is tried instead where every decision takes long, and how often a step is halved.
_FEWER_STEPS, _HALVINGS = (100, 50, 20), 20


@dataclass(frozen=True, eq=False)
class Flips:
    """Everything nearby that would change a decision."""

    decision: Decision
    features: tuple[FeatureFlips, ...]  # [D]
    certificate: Certificate | None  # None: no one option decides, so nothing is certain.
    steps: int = 0  # Each way along a feature, where flips were found by trying; 0: exact.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.

    @property
    def nearest(self) -> Flip | None:
        """The flip of a single feature that is the least distance away."""
        found = [f for both in self.features for f in (both.less, both.more) if f is not None]
        return min(found, key=lambda flip: flip.distance, default=None)


def explain_flips(mind: Mind, decision: Decision, ranges: Ranges, steps: int = STEPS) -> Flips:
    """What would flip a decision; exact and certified where one option decides by its plane.

    Elsewhere so many steps are tried each way along a feature.
    """
    if mind.is_piecewise_linear:
        certificate = certify(mind, decision.observation)
        return Flips(decision, find_flips(mind, decision, ranges), certificate)
    return Flips(decision, bracket_flips(mind, decision, ranges, steps), None, steps)


def affordable_steps(mind: Mind, observation: NDArray[np.float64], budget_s: float) -> int:
    """Steps that `explain_flips` can try each way within a time; 0: not even the fewest.

    Only thinking ahead can take long; how long, one decision at the observation [D] tells.
    """
    if not mind.thinks_ahead:
        return STEPS
    mind.act(observation)  # The first one may have to be compiled.
    begun = time.perf_counter()
    mind.act(observation)
    seconds = time.perf_counter() - begun
    for steps in (STEPS, *_FEWER_STEPS):
        if 2 * len(observation) * (steps + _HALVINGS) * seconds <= budget_s:
            return steps
    return 0


def find_flips(mind: Mind, decision: Decision, ranges: Ranges) -> tuple[FeatureFlips, ...]:
    """The nearest flip of each feature, both ways; exact.

    Every flip was checked: the agent, asked just beyond the border, chooses otherwise. Where a
    toss decides, that is a place where it falls otherwise; the border is where tossing begins.

    Raises:
        ValueError: If the mind does not decide by one option's plane; see `bracket_flips`.
    """
    # An action drawn at random is no choice: what would be chosen here is what can flip.
    action = mind.act(decision.observation)
    found = []
    for feature in range(len(decision.observation)):
        pieces = scan_line(mind, decision.observation, feature, ranges)
        less, more = (
            _find_flip(mind, decision.observation, action, feature, pieces, way) for way in (-1, 1)
        )
        low, high = float(ranges.low[feature]), float(ranges.high[feature])
        found.append(FeatureFlips(feature, low, high, less, more))
    return tuple(found)


def _find_flip(
    mind: Mind,
    observation: NDArray[np.float64],
    action: int,
    feature: int,
    pieces: tuple[Piece, ...],
    way: int,
) -> Flip | None:
    seen = float(observation[feature])
    before = NO_OPTION
    for near, far, piece in _walk(pieces, seen, way):
        if piece.actions != (action,):
            beyond = _find_beyond(mind, observation, action, feature, near, far, piece)
            if beyond is not None:
                kind = FlipKind.CROSSING if piece.option == before else FlipKind.BORDER
                if action in piece.actions:
                    kind = FlipKind.TIE
                return _make_flip(mind, observation, feature, kind, near, beyond, 0.0)
        before = piece.option
    return None


def _walk(pieces: tuple[Piece, ...], seen: float, way: int) -> Iterator[tuple[float, float, Piece]]:
    """The pieces on the way out from what was seen, each with its near and far end."""
    for piece in pieces if way > 0 else reversed(pieces):
        near, far = (piece.start, piece.end) if way > 0 else (piece.end, piece.start)
        if way * far > way * seen:
            yield max(near, seen, key=lambda x: way * x), far, piece


def _find_beyond(
    mind: Mind,
    observation: NDArray[np.float64],
    action: int,
    feature: int,
    near: float,
    far: float,
    piece: Piece,
) -> float | None:
    """A value just inside a piece at which the agent chooses otherwise; None: it never does.

    That can be where a piece is too short for numbers to lie in it.
    """
    way = 1.0 if far > near else -1.0
    room = abs(far - near)
    # What a small distance is in this feature, for places around zero.
    small = 1e-3 / max(float(mind.view.attention[feature]), 1e-9)
    step = _FIRST_STEP * max(abs(near), abs(float(observation[feature])), small)
    tosses = 0
    asked = observation.copy()
    while True:
        step = min(step, room if np.isfinite(room) else step)
        asked[feature] = near + way * step
        chosen = mind.act(asked)
        if chosen != action:
            return float(asked[feature])
        if action in piece.actions:
            # Places close together toss differently, too.
            tosses += 1
            step *= 1.1
            if tosses == _TOSSES:
                return None
        elif step >= room:
            return None
        else:
            step *= 2


def _make_flip(
    mind: Mind,
    observation: NDArray[np.float64],
    feature: int,
    kind: FlipKind,
    border: float,
    beyond: float,
    tolerance: float,
) -> Flip:
    there = observation.copy()
    there[feature] = beyond
    decision = mind.decide(there)
    values = mind.view.values[mind.view.is_alive, feature]
    change = border - float(observation[feature])
    return Flip(
        feature=feature,
        kind=kind,
        border=border,
        beyond=beyond,
        change=change,
        distance=abs(change) * float(mind.view.attention[feature]),
        action=decision.action,
        option=int(decision.voters[0]) if len(decision.voters) else NO_OPTION,
        tolerance=tolerance,
        is_familiar=bool(len(values) and values.min() <= beyond <= values.max()),
    )


def bracket_flips(
    mind: Mind, decision: Decision, ranges: Ranges, steps: int = STEPS
) -> tuple[FeatureFlips, ...]:
    """The nearest flip of each feature that trying finds; for votes and thinking ahead.

    Each direction is tried in so many equal steps, to the end of the feature's range, or of what
    the options' values span with half as much again on both sides, where that is less. The first
    step that changes the action is halved until the border is known to a millionth of it. What
    changes and changes back within one step is not seen.
    """
    action = mind.act(decision.observation)
    found = []
    for feature in range(len(decision.observation)):
        low, high = _span(mind, decision.observation, feature, ranges)
        less, more = (
            _bracket(mind, decision.observation, action, feature, end, steps) for end in (low, high)
        )
        found.append(FeatureFlips(feature, low, high, less, more))
    return tuple(found)


def _span(
    mind: Mind, observation: NDArray[np.float64], feature: int, ranges: Ranges
) -> tuple[float, float]:
    values = np.append(mind.view.values[mind.view.is_alive, feature], observation[feature])
    spare = (values.max() - values.min()) / 2
    return (
        max(float(ranges.low[feature]), float(values.min() - spare)),
        min(float(ranges.high[feature]), float(values.max() + spare)),
    )


def _bracket(
    mind: Mind,
    observation: NDArray[np.float64],
    action: int,
    feature: int,
    end: float,
    steps: int,
) -> Flip | None:
    seen = float(observation[feature])
    asked = observation.copy()
    near = seen
    for far in np.linspace(seen, end, steps + 1)[1:].tolist():
        asked[feature] = far
        if mind.act(asked) != action:
            break
        near = far
    else:
        return None
    tolerance = abs(far - near) * 1e-6
    while abs(far - near) > tolerance:
        asked[feature] = middle = (near + far) / 2
        if middle in (near, far):
            break
        if mind.act(asked) != action:
            far = middle
        else:
            near = middle
    return _make_flip(mind, observation, feature, FlipKind.BRACKETED, near, far, abs(far - near))


def tell_flips(flips: Flips, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences: one for each feature, and what is certain."""
    told = [_tell_feature(both, flips.decision, spec) for both in flips.features]
    certificate = flips.certificate
    if certificate is None:
        told.append(
            f"Found by trying, in {flips.steps} steps each way: what changes and changes back "
            f"within a step was not seen."
        )
    elif np.isinf(certificate.radius):
        told.append("Whatever is seen, no option chooses otherwise.")
    elif certificate.radius > 0:
        told.append(
            f"Certain: whatever changes, as long as the changes add up to a distance of less than "
            f"{number(certificate.radius)}, the action stays the same."
        )
    else:
        told.append("Nothing is certain: it was a tie, or the choice is on the edge.")
    return tuple(told)


def _tell_feature(both: FeatureFlips, decision: Decision, spec: TaskSpec) -> str:
    feature = spec.features[both.feature]
    name, seen = feature.name, amount(float(decision.observation[both.feature]), feature)
    found = [flip for flip in (both.less, both.more) if flip is not None]
    if not found:
        return f"{capitalised(name)} ({seen}): nothing in its range changes the action."
    told = []
    for flip in found:
        word = "less" if flip is both.less else "more"
        what = f"{amount(abs(flip.change), feature)} {word} ({amount(flip.beyond, feature)})"
        if flip.kind is FlipKind.TIE:
            what += " it comes to a toss"
        else:
            what += f" gives {spec.action_names[flip.action]}"
        if flip.tolerance:
            what += f", to within {amount(flip.tolerance, feature)}"
        if not flip.is_familiar:
            what += ", beyond all that it has met"
        told.append(what)
    return f"{capitalised(name)} ({seen}): {'; '.join(told)}."
