"""Accommodation: making room in the forest for what no option stands for yet."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import distance
from ao2viz.core.compiled import compiled
from ao2viz.core.decision import NO_OPTION

MAX_LINKS = 32
"""The most extra parents a new option is linked to."""


@compiled
def find_parent(
    scaled: NDArray[np.float64],
    first_child: NDArray[np.int64],
    next_sibling: NDArray[np.int64],
    first_root: int,
    query: NDArray[np.float64],
    levels: int,
    links: NDArray[np.int64],
) -> tuple[int, int]:
    """Where a new option belongs: its parent (NO_OPTION: a new root) and how many extra parents.

    From the nearest root within radius 1 down into the nearest child that covers the query; the
    radius halves at each level. Siblings of the parent that cover it as well are written to
    `links`: they become parents beside the tree. Takes three of the columns rather than all:
    handing them over costs more than the descent.
    """
    parent = NO_OPTION
    radius = 1.0
    covering = 0
    child = first_root
    for _ in range(levels):
        best = NO_OPTION
        best_distance = radius
        found = 0
        while child >= 0:
            d = distance(scaled, child, query)
            if d <= radius:
                if best < 0 or d < best_distance or (d == best_distance and child < best):
                    best, best_distance = child, d
                if found < MAX_LINKS:
                    links[found] = child
                    found += 1
            child = next_sibling[child]
        if best < 0:
            break
        parent = best
        covering = 0
        for n in range(found):
            if links[n] != parent:
                links[covering] = links[n]
                covering += 1
        child = first_child[parent]
        radius *= 0.5
    return parent, covering
