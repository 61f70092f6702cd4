"""The growing arrays of a forest, and the compiled code that keeps the tree in them sound."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.compiled import compiled, compiled_long
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.index import Index, index_option, make_index


class Columns(NamedTuple):
    """The growing arrays of a forest; `C` is the capacity, rows past the last option are unused.

    A NamedTuple, not a class: numba compiles it as plain arrays.
    """

    values: NDArray[np.float64]  # [C, D] environment units.
    scaled: NDArray[np.float64]  # [C, D] values times attention; distances are taken here.
    parents: NDArray[np.int64]  # [C] NO_OPTION at a root.
    first_child: NDArray[np.int64]  # [C] NO_OPTION at a leaf.
    next_sibling: NDArray[np.int64]  # [C] roots are one another's siblings.
    depths: NDArray[np.int64]  # [C] 0 at a root.
    is_alive: NDArray[np.bool_]  # [C]
    born: NDArray[np.int64]  # [C] the agent's step at which it was made.
    weights: NDArray[np.float64]  # [C, A] what each action is expected to earn.
    visits: NDArray[np.int64]  # [C, A] how often each action was tried here.
    places: Index  # Where the living options lie; grows at its own pace.


# numba finds the type of a plain tuple several times faster than that of a NamedTuple, and it asks
# at every call from Python. Where that happens every step, structs are handed over as plain tuples
# and get their names back inside.
PlainColumns = tuple[Any, ...]
"""What `to_plain` makes of columns."""


def to_plain(columns: Columns) -> PlainColumns:
    """The columns as plain tuples, for compiled code that calls `to_columns`."""
    return (*columns[:-1], tuple(columns.places))


@compiled
def to_columns(plain: PlainColumns) -> Columns:
    """The columns that `to_plain` took the names off."""
    # All but the last: ten, which a type checker cannot know.
    return Columns(*plain[:-1], Index(*plain[-1]))  # pyright: ignore[reportCallIssue]


@compiled
def distance(scaled: NDArray[np.float64], row: int, query: NDArray[np.float64]) -> float:
    """L1 distance between an option and a query, both scaled by the attention weights."""
    total = 0.0
    for d in range(query.shape[0]):
        total += abs(scaled[row, d] - query[d])
    return total


@compiled
def insert(columns: Columns, heads: NDArray[np.int64], row: int, parent: int) -> None:
    """Hangs a row into the tree, in front of its siblings."""
    columns.parents[row] = parent
    if parent < 0:
        columns.depths[row] = 0
        columns.next_sibling[row] = heads[0]
        heads[0] = row
        return
    columns.depths[row] = columns.depths[parent] + 1
    columns.next_sibling[row] = columns.first_child[parent]
    columns.first_child[parent] = row


@compiled_long
def insert_all(
    columns: Columns,
    heads: NDArray[np.int64],
    rows: NDArray[np.int64],
    parents: NDArray[np.int64],
) -> None:
    """Hangs rows that are in no tree below their `parents` [C], which must come before them."""
    for row in rows:
        insert(columns, heads, row, int(parents[row]))


@compiled
def add_row(
    columns: Columns,
    heads: NDArray[np.int64],
    value: NDArray[np.float64],
    scaled: NDArray[np.float64],
    parent: int,
    step: int,
) -> int:
    """Writes a new option into the next free row and returns its id; capacity must suffice."""
    row = heads[1]
    heads[1] += 1
    columns.values[row] = value
    columns.scaled[row] = scaled
    columns.first_child[row] = NO_OPTION
    columns.is_alive[row] = True
    columns.born[row] = step
    columns.weights[row] = 0.0
    columns.visits[row] = 0
    insert(columns, heads, row, parent)
    index_option(columns.places, columns.scaled, row)
    return row


def walk_siblings(columns: Columns, option: int) -> Iterator[int]:
    """An option and the siblings after it; the tree may change behind the walk."""
    while option != NO_OPTION:
        following = int(columns.next_sibling[option])
        yield option
        option = following


def allocate(capacity: int, n_features: int, n_actions: int) -> Columns:
    """Empty columns for so many options, and an empty index that still has to grow."""
    return Columns(
        values=np.zeros((capacity, n_features)),
        scaled=np.zeros((capacity, n_features)),
        parents=np.full(capacity, NO_OPTION, np.int64),
        first_child=np.full(capacity, NO_OPTION, np.int64),
        next_sibling=np.full(capacity, NO_OPTION, np.int64),
        depths=np.zeros(capacity, np.int64),
        is_alive=np.zeros(capacity, np.bool_),
        born=np.zeros(capacity, np.int64),
        weights=np.zeros((capacity, n_actions)),
        visits=np.zeros((capacity, n_actions), np.int64),
        places=make_index(np.zeros((0, n_features)), np.zeros(0, np.int64)),
    )
