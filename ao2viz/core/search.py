"""The most similar options, found by walking down the forest itself.

Each option knows its *reach*: the greatest distance to any of its descendants. By the triangle
inequality no descendant of an option at distance d can be closer than d - reach, so whole
subtrees are skipped without losing exactness (branch and bound). Distances are weighted L1
(paper, equation 1), taken as plain L1 between vectors already scaled by the attention weights.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns, distance
from ao2viz.core.compiled import compiled

ANY_ACTION = -1
# The walk compares rounded sums, so a bound is loosened by far more than rounding can spoil.
_SLACK = 1e-9


class Scratch(NamedTuple):
    """Work space of the walk, allocated once per capacity."""

    stack: NDArray[np.int64]  # [C]
    bounds: NDArray[np.float64]  # [C]


@compiled
def find_nearest(
    columns: Columns,
    first_root: int,
    query: NDArray[np.float64],
    action: int,
    limit: float,
    scratch: Scratch,
    ids: NDArray[np.int64],
    distances: NDArray[np.float64],
) -> int:
    """Writes the nearest options, closest first, into `ids` and `distances`; returns how many.

    Ties go to the oldest option. With an `action` only options that tried it count. Options
    farther than `limit` are left out.
    """
    wanted = ids.shape[0]
    found = 0
    worst = limit
    stack, bounds = scratch.stack, scratch.bounds
    top = 0
    child = first_root
    while True:
        base = top
        while child >= 0:
            d = distance(columns.scaled, child, query)
            if d <= worst and (action < 0 or columns.visits[child, action] > 0):
                if found < wanted:
                    slot = found
                    found += 1
                else:
                    slot = wanted  # Drops off the end unless it is better than the last.
                    if d < distances[wanted - 1] or (
                        d == distances[wanted - 1] and child < ids[wanted - 1]
                    ):
                        slot = wanted - 1
                if slot < wanted:
                    while slot > 0 and (
                        d < distances[slot - 1]
                        or (d == distances[slot - 1] and child < ids[slot - 1])
                    ):
                        distances[slot] = distances[slot - 1]
                        ids[slot] = ids[slot - 1]
                        slot -= 1
                    distances[slot] = d
                    ids[slot] = child
                    if found == wanted:
                        worst = distances[wanted - 1]
            if columns.first_child[child] >= 0:
                bound = d - columns.reach[child] * (1.0 + _SLACK) - d * _SLACK
                if bound <= worst:
                    # Kept sorted, the closest on top: a good candidate early prunes the rest.
                    place = top
                    top += 1
                    while place > base and bounds[place - 1] < bound:
                        bounds[place] = bounds[place - 1]
                        stack[place] = stack[place - 1]
                        place -= 1
                    bounds[place] = bound
                    stack[place] = child
            child = int(columns.next_sibling[child])
        while top > 0 and bounds[top - 1] > worst:
            top -= 1
        if top == 0:
            return found
        top -= 1
        child = int(columns.first_child[stack[top]])


def make_scratch(capacity: int) -> Scratch:
    """Work space for a forest of this capacity."""
    return Scratch(np.empty(capacity, np.int64), np.empty(capacity, np.float64))
