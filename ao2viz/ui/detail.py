"""How much of a forest is drawn: all of it, or as much as a page can show at ease."""

from enum import Enum

import numpy as np
from numpy.typing import NDArray

MOST_SHAPES = 20_000
"""So many options have a shape of their own, whose size tells of visits, and lines between them."""
MOST_DOTS = 200_000
"""So many are drawn at all: beyond the shapes as dots of one size, without lines."""


class Detail(Enum):
    """What is drawn of the options that a person wants to see."""

    FULL = "all, in full"
    DOTS = "all, as dots"
    ROOTS = "the roots"


def detail_for(n_wanted: int) -> Detail:
    """How so many options are drawn; the active schemas are drawn in full in any case."""
    if n_wanted <= MOST_SHAPES:
        return Detail.FULL
    return Detail.DOTS if n_wanted <= MOST_DOTS else Detail.ROOTS


def choose_roots(
    roots: NDArray[np.int64], schemas: NDArray[np.int64], is_wanted: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """The roots to draw, by age: all, or those of the MOST_SHAPES biggest schemas.

    Args:
        roots: Ids.
        schemas: [N] the root of each option.
        is_wanted: [N] which of them count.
    """
    if len(roots) <= MOST_SHAPES:
        return roots
    counts = np.bincount(schemas[is_wanted], minlength=len(schemas))[roots]
    return np.sort(roots[np.argsort(-counts, kind="stable")[:MOST_SHAPES]])
