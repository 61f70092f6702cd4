"""What is drawn over the forest: the decision, the selection, where things are, and their names."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.catalogue import Feature
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.ahead import Ahead
from ao2viz.explain.words import count, number
from ao2viz.layout.labels import Side
from ao2viz.layout.state_space import Axes, find_ticks
from ao2viz.ui.detail import Detail
from ao2viz.ui.picture import Picture

SHARE_LEVELS = 3
"""Other voters' paths come in so many widths, the widest for the biggest shares."""

_LATER = (8, 24)  # After so many moves of it, the imagined way is drawn thinner.
AHEAD_LEVELS = len(_LATER) + 1
"""The imagined way comes in so many widths, the widest first: a long one stays readable."""

_TRAIL = 40  # So many of the latest states are joined to a line.
_FOLDED_LABELS = 8
_DASHES = 110  # Of the imagined way, side by side across the whole picture.
_TICK_SIZE = 0.012  # Of the longest axis.


@dataclass(frozen=True, eq=False)
class Label:
    """A few words on the canvas."""

    text: str
    position: tuple[float, float, float]
    sides: tuple[Side, ...]  # Allowed places beside its point, the best first.


@dataclass(frozen=True, eq=False)
class Moment:
    """What the overlay tells of: one step of what is watched, and what a person chose."""

    decision: Decision | None
    selected: int = NO_OPTION
    seen: NDArray[np.float64] | None = None  # [T, D] the states up to now, the latest last.
    ahead: Ahead | None = None  # Where the agent expects to go from here.
    is_supposed: bool = False  # A what-if, not what happened.


@dataclass(frozen=True, eq=False)
class Overlay:
    """What lies over the picture; positions are scene coordinates."""

    path: NDArray[np.float32]  # [P, 3] root … most similar option; empty without a decision.
    path_sizes: NDArray[np.float32]  # [P] radii of the options on it.
    path_colors: NDArray[np.uint8]  # [P, 3] their own colours, kept in the middle.
    votes: tuple[NDArray[np.float32], ...]  # [V, 2, 3] segments for each level of share.
    voters: NDArray[np.float32]  # [K, 3] the other voters.
    voter_sizes: NDArray[np.float32]  # [K] by share.
    selected: NDArray[np.float32] | None  # [3]
    schema: NDArray[np.float32]  # [E, 2, 3] in the state space: edges of the active schema.
    now: NDArray[np.float32] | None  # [3] in the state space: where the state is.
    trail: NDArray[np.float32]  # [T, 2, 3] in the state space: the way there.
    axes: NDArray[np.float32]  # [A, 2, 3] in the state space: axes with their ticks.
    ahead: tuple[NDArray[np.float32], ...]  # [I, 2, 3] dashes of the imagined way, by width.
    ahead_end: NDArray[np.float32] | None  # [3] where that ends.
    labels: tuple[Label, ...]  # The most important first.


def overlay(moment: Moment, picture: Picture, view: ForestView, spec: TaskSpec) -> Overlay:
    """Works out the overlay; options that have no place in the picture are left out."""
    decision = moment.decision
    path = _standing(decision.path if decision is not None else np.empty(0, np.int64), picture)
    votes, voters, sizes = _votes(decision, picture)
    labels = [
        *_path_labels(moment, path, picture, spec),
        *_selected_label(moment, path, picture),
        *_folded_labels(picture, view),
    ]
    way = _imagined_way(moment.ahead, path, picture)
    if len(way) and moment.ahead is not None:
        labels.insert(min(2, len(labels)), _label(_ahead_label(moment.ahead), way[-1], _SIDES))
    now: NDArray[np.float32] | None = None
    trail, axes = np.empty((0, 2, 3), np.float32), np.empty((0, 2, 3), np.float32)
    schema = trail
    if picture.axes is not None:
        # Where not all is drawn in full, the close-up has the lines of the active schemas.
        is_full = picture.detail is Detail.FULL
        schema = trail if not is_full else _active_schema(moment, path, picture, view)
        axes = _axis_lines(picture.axes, spec)
        if moment.seen is not None and len(moment.seen):
            came = picture.axes.place(moment.seen[-_TRAIL:]).astype(np.float32)
            now, trail = came[-1], np.stack([came[:-1], came[1:]], axis=1)
            here = "what if" if moment.is_supposed else "now"
            labels.insert(1, _label(here, came[-1], _AWAY[True, True]))
        labels += _axis_labels(picture.axes, spec)
    return Overlay(
        path=picture.positions[path],
        path_sizes=np.maximum(picture.sizes[path], 0.2),
        path_colors=picture.colors[path],
        votes=votes,
        voters=voters,
        voter_sizes=sizes,
        selected=picture.position_of(moment.selected),
        schema=schema,
        now=now,
        trail=trail,
        axes=axes,
        ahead=_dashes(way, picture),
        ahead_end=way[-1] if len(way) else None,
        labels=tuple(labels),
    )


def _imagined_way(
    ahead: Ahead | None, path: NDArray[np.int64], picture: Picture
) -> NDArray[np.float32]:
    """[W, 3] option by option; in the state space, state by state."""
    if ahead is None or not ahead.steps:
        return np.empty((0, 3), np.float32)
    if picture.axes is not None:
        states = np.stack([*(step.observation for step in ahead.steps), ahead.last])
        return picture.axes.place(states).astype(np.float32)
    options = np.array([*path[-1:], *(stretch[0].option for stretch in ahead.stretches)], np.int64)
    options = _standing(options, picture)
    moves = np.r_[True, options[1:] != options[:-1]] if len(options) else np.empty(0, np.bool_)
    return picture.positions[options[moves]]


def _dashes(way: NDArray[np.float32], picture: Picture) -> tuple[NDArray[np.float32], ...]:
    """[I, 2, 3] the way in dashes, by width; what is gone more than once is drawn once."""
    nothing = np.empty((0, 2, 3), np.float32)
    if len(way) < 2:
        return (nothing,) * AHEAD_LEVELS
    legs = np.stack([way[:-1], way[1:]], axis=1)
    ordered = np.where((legs[:, :1] > legs[:, 1:]).any(axis=2, keepdims=True), legs[:, ::-1], legs)
    _, first = np.unique(ordered.round(4).reshape(len(legs), 6), axis=0, return_index=True)
    reach = picture.outline[:, 3:]
    box = (picture.outline[:, :3] + reach).max(axis=0) - (picture.outline[:, :3] - reach).min(
        axis=0
    )
    dash = float(box.max()) / _DASHES
    dashes: list[list[NDArray]] = [[nothing] for _ in range(AHEAD_LEVELS)]
    for leg in np.sort(first):
        start, end = legs[leg]
        count = max(1, min(_DASHES, round(float(np.linalg.norm(end - start)) / dash / 2)))
        at = (np.arange(count)[:, None] + np.array([0.0, 0.55])) / count
        level = int(np.searchsorted(_LATER, leg, side="right"))
        dashes[level].append(start + (end - start) * at[..., None])
    return tuple(np.concatenate(level).astype(np.float32) for level in dashes)


def _ahead_label(ahead: Ahead) -> str:
    # How it ends is told under Why: so long a label fits on few narrow canvases.
    return f"expects {number(ahead.reward)} in {count(len(ahead.steps), 'step')}"


def _standing(options: NDArray[np.int64], picture: Picture) -> NDArray[np.int64]:
    """Those that have a place; hidden ones as well, for a path is never shown in part."""
    inside = options[(options >= 0) & (options < len(picture.stands))]
    return inside[picture.stands[inside]]


def _votes(
    decision: Decision | None, picture: Picture
) -> tuple[tuple[NDArray[np.float32], ...], NDArray[np.float32], NDArray[np.float32]]:
    segments: list[list[NDArray[np.float32]]] = [[] for _ in range(SHARE_LEVELS)]
    voters, sizes = [], []
    most = float(decision.shares.max()) if decision is not None and len(decision.shares) else 0.0
    for voter in range(1, len(decision.voters) if decision is not None and most > 0 else 0):
        assert decision is not None
        strength = float(decision.shares[voter]) / most
        path = _standing(decision.path_of(voter), picture)
        if strength <= 0 or len(path) == 0:
            continue
        points = picture.positions[path]
        level = min(SHARE_LEVELS - 1, int(strength * SHARE_LEVELS))
        segments[level].append(np.stack([points[:-1], points[1:]], axis=1))
        voters.append(points[-1])
        sizes.append(0.45 + 0.3 * strength)
    empty = np.empty((0, 2, 3), np.float32)
    return (
        tuple(np.concatenate([empty, *level]) for level in segments),
        np.array(voters, np.float32).reshape(-1, 3),
        np.array(sizes, np.float32),
    )


def _active_schema(
    moment: Moment, path: NDArray[np.int64], picture: Picture, view: ForestView
) -> NDArray[np.float32]:
    active = int(path[-1]) if len(path) else moment.selected
    if picture.position_of(active) is None:
        return np.empty((0, 2, 3), np.float32)
    return picture.edges_of_schema(int(picture.schemas[active]), view)


# Allowed sides by (is the point on the right of the middle, is it above its partner).
_AWAY: dict[tuple[bool, bool], tuple[Side, ...]] = {
    (True, True): (Side.LEFT_ABOVE, Side.RIGHT_ABOVE, Side.LEFT, Side.RIGHT, Side.LEFT_BELOW),
    (True, False): (Side.LEFT_BELOW, Side.RIGHT_BELOW, Side.LEFT, Side.RIGHT, Side.LEFT_ABOVE),
    (False, True): (Side.RIGHT_ABOVE, Side.LEFT_ABOVE, Side.RIGHT, Side.LEFT, Side.RIGHT_BELOW),
    (False, False): (Side.RIGHT_BELOW, Side.LEFT_BELOW, Side.RIGHT, Side.LEFT, Side.RIGHT_ABOVE),
}


_SIDES = _AWAY[False, False]


def _path_labels(
    moment: Moment, path: NDArray[np.int64], picture: Picture, spec: TaskSpec
) -> list[Label]:
    decision = moment.decision
    if decision is None or len(path) == 0:
        return []
    root, chosen = picture.positions[path[0]], picture.positions[path[-1]]
    middle = float(picture.outline[:, 0].mean())
    is_root_above = bool(root[1] > chosen[1])
    name = f"option {path[-1]} → {spec.action_names[decision.action]}"
    if moment.is_supposed:
        name = f"what if: {name}"
    labels = [_label(name, chosen, _AWAY[bool(chosen[0] > middle), not is_root_above])]
    if len(path) > 1:
        sides = _AWAY[bool(root[0] > middle), is_root_above]
        labels.append(_label(f"root {path[0]}", root, sides))
    return labels


def _selected_label(moment: Moment, path: NDArray[np.int64], picture: Picture) -> list[Label]:
    place = picture.position_of(moment.selected)
    if place is None or moment.selected in (path[:1].tolist() + path[-1:].tolist()):
        return []
    return [_label(f"selected {moment.selected}", place, _AWAY[False, True])]


def _folded_labels(picture: Picture, view: ForestView) -> list[Label]:
    """How many options the biggest folded schemas hide."""
    alive = picture.schemas[view.is_alive[: len(picture.schemas)]]
    counts = [(int(np.count_nonzero(alive == root)), int(root)) for root in picture.folded]
    return [
        _label(f"root {root} + {count - 1:,}", picture.positions[root], _AWAY[False, False])
        for count, root in sorted(counts, reverse=True)[:_FOLDED_LABELS]
    ]


def _axis_lines(axes: Axes, spec: TaskSpec) -> NDArray[np.float32]:
    low, high = axes.box
    size = float((high - low).max()) * _TICK_SIZE
    lines = []
    for k, (direction, outward) in enumerate(_DIRECTIONS[: len(axes.features)]):
        end = low + (high - low) * direction
        lines.append([low, end])
        for value, _ in _ticks_of(axes, k, spec.features[axes.features[k]]):
            place = _on_axis(axes, k, value)
            lines.append([place, place + outward * size])
    return np.array(lines, np.float32)


def _axis_labels(axes: Axes, spec: TaskSpec) -> list[Label]:
    """Names with units first, then the numbers at the ends; they stand outside of the box."""
    low, high = axes.box
    size = float((high - low).max()) * _TICK_SIZE
    names, numbers = [], []
    for k, (direction, outward) in enumerate(_DIRECTIONS[: len(axes.features)]):
        feature = spec.features[axes.features[k]]
        if k == 0:
            middle = low + (high - low) * direction * 0.5 + outward * size
            names.append(_label(_name_of(feature), middle, _AXIS_SIDES[0]))
        else:
            names.append(_label(_name_of(feature), low + (high - low) * direction, _AT_END))
        ticks = _ticks_of(axes, k, feature)
        for value, words in {ticks[0], ticks[-1]}:
            place = _on_axis(axes, k, value) + outward * size
            numbers.append(_label(words, place, _AXIS_SIDES[k]))
    return names + numbers


def _ticks_of(axes: Axes, k: int, feature: Feature) -> list[tuple[float, str]]:
    """Round numbers in the unit that people read, with the values they stand for."""
    shown = find_ticks(float(axes.low[k]) * feature.scale, float(axes.high[k]) * feature.scale)
    return [(float(tick) / feature.scale, number(float(tick))) for tick in shown]


def _name_of(feature: Feature) -> str:
    return f"{feature.name} ({feature.unit})" if feature.unit else feature.name


def _on_axis(axes: Axes, k: int, value: float) -> NDArray[np.float64]:
    place = axes.box[0].copy()
    place[k] = (value - axes.origin[k]) * axes.scale[k]
    return place


# Where each axis leads to, and where its words stand.
_DIRECTIONS = tuple(
    (np.array(along, float), np.array(outward, float))
    for along, outward in (
        ((1, 0, 0), (0, -1, 0)),
        ((0, 1, 0), (-1, 0, 0)),
        ((0, 0, 1), (-1, 0, 0)),
    )
)
_AT_END = (Side.RIGHT_ABOVE, Side.LEFT_ABOVE)
_AXIS_SIDES = (
    (Side.RIGHT_BELOW, Side.LEFT_BELOW),
    (Side.LEFT, Side.RIGHT),
    (Side.LEFT, Side.RIGHT_ABOVE),
)


def _label(text: str, point: NDArray, sides: tuple[Side, ...]) -> Label:
    return Label(text, (float(point[0]), float(point[1]), float(point[2]) + 0.5), sides)
