"""Words beside points that never cover one another, nor what they should leave free."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray


class Side(Enum):
    """Where a label stands, seen from its point: (to the right, downwards), in label sizes."""

    RIGHT_ABOVE = (0.0, -1.0)
    LEFT_ABOVE = (-1.0, -1.0)
    RIGHT_BELOW = (0.0, 0.0)
    LEFT_BELOW = (-1.0, 0.0)
    RIGHT = (0.0, -0.5)
    LEFT = (-1.0, -0.5)


@dataclass(frozen=True, eq=False)
class Words:
    """A label to be placed; lengths are pixels, y goes down."""

    point: tuple[float, float]
    size: tuple[float, float]
    sides: tuple[Side, ...] = tuple(Side)  # Allowed ones, the best first.


def place_labels(
    labels: list[Words],
    window: tuple[float, float],
    keep_free: NDArray[np.float64],
) -> list[Side | None]:
    """A side for each label, or None for those that must not be shown; the first matter most.

    No two labels overlap, none leaves the window, and none whose point is outside is shown. Of the
    sides that are left the one that covers the least of `keep_free` is taken.

    Args:
        labels: In order of importance.
        window: Width and height.
        keep_free: [M, 2] points that are better not covered.
    """
    taken: list[tuple[float, float, float, float]] = []
    sides: list[Side | None] = []
    for label in labels:
        best: Side | None = None
        fewest = np.inf
        for side in label.sides:
            box = box_of(label, side)
            if not _is_inside(box, window) or any(_overlap(box, other) for other in taken):
                continue
            covered = _count_inside(keep_free, box)
            if covered < fewest:
                best, fewest = side, covered
        sides.append(best)
        if best is not None:
            taken.append(box_of(label, best))
    return sides


def box_of(label: Words, side: Side) -> tuple[float, float, float, float]:
    """Left, top, right, bottom of a label on a side of its point."""
    (x, y), (width, height) = label.point, label.size
    left, top = x + side.value[0] * width, y + side.value[1] * height
    return left, top, left + width, top + height


def _is_inside(box: tuple[float, float, float, float], window: tuple[float, float]) -> bool:
    return box[0] >= 0 and box[1] >= 0 and box[2] <= window[0] and box[3] <= window[1]


def _overlap(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _count_inside(points: NDArray[np.float64], box: tuple[float, float, float, float]) -> int:
    left, top, right, bottom = box
    x, y = points[:, 0], points[:, 1]
    return int(np.count_nonzero((x > left) & (x < right) & (y > top) & (y < bottom)))
