"""What an agent does along a line: one feature changes, the others stay as they are.

Exact where one option decides by its plane (`Mind.is_piecewise_linear`). With all features but
one held, option i is base_i + |s − c_i| away, where s is the scaled feature and c_i the option's
value of it. All these cones have the same slopes, so an option is the most similar somewhere
exactly if it is at its own tip c_i, and the options that are so border on each other midway
between their reaches: s = (c_i + c_j + base_j − base_i) / 2 for neighbours c_i < c_j. Between two
borders one option decides, and every action's expectation is a line in s; the greatest of them is
found from crossing to crossing. So nothing on the line is missed.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges


@dataclass(frozen=True)
class Piece:
    """A stretch of the line on which one option decides for the same action all the way."""

    start: float  # Of the feature, environment units; may be −inf.
    end: float
    option: int
    actions: tuple[int, ...]  # The best action; several: they tie all along, a toss decides.


def scan_line(
    mind: Mind, observation: NDArray[np.float64], feature: int, ranges: Ranges
) -> tuple[Piece, ...]:
    """Everything that the agent does as a feature goes through its range, in order.

    Pieces border on each other without a gap. What happens at a border itself, the agent's own
    rounding decides. Empty while there are no options.

    Raises:
        ValueError: If the mind does not decide by one option's plane.
    """
    if not mind.is_piecewise_linear:
        raise ValueError(
            "Expected an agent that decides by path and does not think ahead: only then does its "
            "choice change along straight borders. Ask by path, or use `bracket_flips`."
        )
    low, high = float(ranges.low[feature]), float(ranges.high[feature])
    alive = np.flatnonzero(mind.view.is_alive)
    if len(alive) == 0:
        return ()
    attention = mind.view.attention
    query = attention * observation
    scaled = mind.forest.columns.scaled
    gaps = np.abs(scaled[alive] - query)
    base = gaps.sum(axis=1) - gaps[:, feature]
    unit = float(attention[feature])
    if unit == 0:  # What has never varied tells nothing apart.
        nearest = int(alive[np.argmin(base)])
        return tuple(_split(mind, nearest, query, feature, low, high, 0.0))
    cells = _find_cells(base, scaled[alive, feature], low * unit, high * unit)
    pieces: list[Piece] = []
    mind.planes([int(alive[cell]) for cell, _, _ in cells])  # All at once.
    for cell, start, end in cells:
        option = int(alive[cell])
        pieces += _split(mind, option, query, feature, start / unit, end / unit, unit)
    return tuple(pieces)


def _find_cells(
    base: NDArray[np.float64], tips: NDArray[np.float64], low: float, high: float
) -> list[tuple[int, float, float]]:
    """Which cone is the lowest between `low` and `high`: (index, start, end) in order.

    Of cones that are equally low over a stretch the first has it, as ties go to the oldest.
    """
    order = np.lexsort((np.arange(len(tips)), base, tips))
    # A cone whose tip lies on or within another one is nowhere the lowest.
    kept = _drop_covered(order, (base - tips)[order])
    kept = _drop_covered(kept[::-1], (base + tips)[kept[::-1]])[::-1]
    cells = []
    start = low
    for place, n in enumerate(kept.tolist()):
        end = high
        if place + 1 < len(kept):
            m = kept[place + 1]
            end = min(high, float((tips[n] + tips[m] + base[m] - base[n]) / 2))
        if end > start or (end == start == high and not cells):
            cells.append((n, start, end))
            start = end
    return cells


def _drop_covered(order: NDArray[np.int64], reach: NDArray[np.float64]) -> NDArray[np.int64]:
    """Of cones in the order of their tips, those that no cone before covers.

    `reach` says how low a cone's far arm lies. On another one's arm, only an older cone is seen.
    """
    lowest = np.minimum.accumulate(reach)
    kept: list[int] = []
    for place in np.flatnonzero(reach <= lowest).tolist():
        is_lower = place == 0 or reach[place] < lowest[place - 1]
        if is_lower or order[place] < kept[-1]:
            kept.append(int(order[place]))
    return np.array(kept, np.int64)


def _split(
    mind: Mind,
    option: int,
    query: NDArray[np.float64],
    feature: int,
    start: float,
    end: float,
    unit: float,
) -> list[Piece]:
    """The stretches of one option's cell, from `start` to `end` in environment units."""
    (levels,), (slopes,) = mind.planes([option])
    value = mind.forest.columns.scaled[option]
    gap = query - value
    gap[feature] = 0.0
    # Each action's expectation as a line in the feature's offset from the option's value.
    heights, steepness = levels + slopes @ gap, slopes[:, feature] * unit
    origin = float(mind.view.values[option, feature])
    _, group = np.unique(np.column_stack([levels, slopes]), axis=0, return_inverse=True)
    group = group.reshape(-1)
    first = start - origin
    last = end - origin
    now = _best_at(heights, steepness, first)
    pieces = []
    while True:
        crossing = last
        following = now
        steeper = np.flatnonzero(steepness > steepness[now])
        if len(steeper):
            over = (heights[now] - heights[steeper]) / (steepness[steeper] - steepness[now])
            nearest = float(over.min())
            if nearest < last:
                crossing = max(nearest, first)
                tied = steeper[over == over.min()]
                following = int(tied[np.argmax(steepness[tied])])
        actions = tuple(np.flatnonzero(group == group[now]).tolist())
        if crossing > first or following == now:
            pieces.append(Piece(first + origin, crossing + origin, option, actions))
        if following == now:
            break
        now, first = following, crossing
    # As given, not as rounded on the way: so the pieces of neighbouring cells border on each other.
    pieces[0] = replace(pieces[0], start=start)
    pieces[-1] = replace(pieces[-1], end=end)
    return pieces


def _best_at(heights: NDArray[np.float64], steepness: NDArray[np.float64], place: float) -> int:
    """Which line is the greatest just after a place; −inf is allowed."""
    if np.isinf(place):
        least = np.flatnonzero(steepness == steepness.min())
        return int(least[np.argmax(heights[least])])
    at = heights + steepness * place
    greatest = np.flatnonzero(at == at.max())
    return int(greatest[np.argmax(steepness[greatest])])
