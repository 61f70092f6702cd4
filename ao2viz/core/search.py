"""The most similar options, found through the index beside the forest.

Whole parts of the index are left out because of their boxes, yet the answer is that of measuring
every option (branch and bound). Distances are weighted L1 (paper, equation 1), taken as plain L1
between vectors already scaled by the attention weights.

No slack is needed for rounding: a box's distance adds the same features in the same order as
`distance`, each gap no greater than that of an option inside, and rounding never turns a smaller
sum into a greater one.
"""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.compiled import compiled
from ao2viz.core.index import Index

ANY_ACTION = -1


@compiled
def kernel_width(nearest: float, radius: float) -> float:
    """How far options still have a say: two radii, or half again as far as the nearest."""
    return max(2.0 * radius, 1.5 * nearest)


@compiled
def find_nearest(
    index: Index,
    visits: NDArray[np.int64],
    query: NDArray[np.float64],
    action: int,
    limit: float,
    radius: float,
    ids: NDArray[np.int64],
    distances: NDArray[np.float64],
) -> int:
    """Writes the nearest options, closest first, into `ids` and `distances`; returns how many.

    Ties go to the oldest option. With an `action` only options that tried it count, as `visits`
    [C, A] tells. Options farther than `limit` are left out, and so are those that would have no
    say at this `radius` (inf: all have); the nearer the nearest, the shorter the search.
    """
    nodes, boxes, points, gaps = index.nodes, index.boxes, index.points, index.gaps
    wanted = ids.shape[0]
    found = 0
    worst = limit
    waiting, bounds = index.waiting, index.bounds
    waiting[0], bounds[0] = 0, 0.0
    height = 1
    while height > 0:
        height -= 1
        node = waiting[height]
        # The cheap bound first: how far the dividing plane is.
        if bounds[height] > worst or _box_distance(boxes, node, query) > worst:
            continue
        while nodes["axis"][node] >= 0:
            gap = query[nodes["axis"][node]] - nodes["split"][node]
            child = nodes["below"][node]
            is_second = 1 if gap >= 0.0 else 0
            node = child + is_second
            waiting[height] = child + 1 - is_second
            bounds[height] = abs(gap)
            height += 1
        bucket = int(nodes["below"][node])
        while bucket >= 0:
            _measure(points, bucket, query, gaps)
            for n in range(index.buckets["fill"][bucket]):
                d = gaps[n]
                if d > worst:
                    continue
                option = index.ids[bucket, n]
                if action >= 0 and visits[option, action] == 0:
                    continue
                if found < wanted:
                    slot = found
                    found += 1
                elif d < distances[wanted - 1] or option < ids[wanted - 1]:
                    slot = wanted - 1
                else:
                    continue
                while slot > 0 and (
                    d < distances[slot - 1] or (d == distances[slot - 1] and option < ids[slot - 1])
                ):
                    distances[slot] = distances[slot - 1]
                    ids[slot] = ids[slot - 1]
                    slot -= 1
                distances[slot] = d
                ids[slot] = option
                if slot == 0:
                    worst = min(worst, kernel_width(d, radius))
                if found == wanted:
                    worst = min(worst, distances[wanted - 1])
            bucket = index.buckets["next"][bucket]
    while found > 0 and distances[found - 1] > kernel_width(distances[0], radius):
        found -= 1
    return found


@compiled
def _box_distance(boxes: NDArray[np.float64], node: int, query: NDArray[np.float64]) -> float:
    """L1 distance from a query to the nearest place in a node's box."""
    total = 0.0
    for d in range(query.shape[0]):
        under = boxes[node, d, 0] - query[d]
        over = query[d] - boxes[node, d, 1]
        total += max(under, over, 0.0)
    return total


@compiled
def _measure(
    points: NDArray[np.float64],
    bucket: int,
    query: NDArray[np.float64],
    gaps: NDArray[np.float64],
) -> None:
    """Writes the distance to every place of a bucket, used or not, into `gaps`.

    One feature after the other, and to the end of the array: so the compiler takes several
    options in one instruction.
    """
    for n in range(gaps.shape[0]):
        gaps[n] = 0.0
    for d in range(query.shape[0]):
        value = query[d]
        for n in range(gaps.shape[0]):
            gaps[n] += abs(points[bucket, d, n] - value)
