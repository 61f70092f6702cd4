"""Where the options lie: a k-d tree of buckets beside the forest, which `search` looks through.

A node halves its options along the feature in which they differ most; a leaf keeps copies of its
own, one feature after the other, so that a whole bucket is measured in one go (Bentley,
Multidimensional binary search trees used for associative searching, 1975; with buckets, Friedman,
Bentley and Finkel, 1977). Everything in here follows from the forest: it is never saved.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.compiled import compiled, compiled_apart, compiled_long

BUCKET = 32
"""Options a bucket holds."""

NONE = -1
_FIRST_BUCKETS = 16
# A node is built anew if it has grown by half since it was built or last looked at, and more than
# this part of its options lie on one side. So however options come, the tree stays shallow.
_LOPSIDED = 0.75


class Index(NamedTuple):
    """Room for `B` buckets and the 2B nodes above them, D features; node 0 is the root.

    A leaf has one bucket; more, in a chain, only if its options are all alike or room is short.
    The children of a node stand side by side.
    """

    heads: NDArray[np.int64]  # [5] free buckets, nodes and buckets ever used, first free of each.
    nodes: NDArray[np.void]  # [2B] of _NODE.
    boxes: NDArray[np.float64]  # [2B, D, 2] least and greatest of its options in each feature.
    buckets: NDArray[np.void]  # [B] of _BUCKET.
    points: NDArray[np.float64]  # [B, D, BUCKET] scaled values.
    ids: NDArray[np.int32]  # [B, BUCKET]
    waiting: NDArray[np.int32]  # [B] nodes still to be seen: work space of every walk.
    bounds: NDArray[np.float64]  # [B] work space of the search, as is `gaps`.
    gaps: NDArray[np.float64]  # [BUCKET]


_NODE = np.dtype(
    [
        ("split", np.float64),  # Options of at least this go to the second child.
        ("axis", np.int32),  # The feature that the node splits, NONE at a leaf.
        ("below", np.int32),  # The first child; at a leaf, its first bucket.
        ("count", np.int32),  # Options below; in a free pair, the next free one.
        ("review", np.int32),  # The count at which it is next asked whether it is lopsided.
    ]
)
_BUCKET = np.dtype(
    [
        ("fill", np.int32),  # Options in it.
        ("next", np.int32),  # The next bucket of the same leaf, or NONE.
    ]
)
_ROOM, _NODES, _BUCKETS, _FREE_PAIR, _FREE_BUCKET = range(5)


def make_index(scaled: NDArray[np.float64], options: NDArray[np.int64]) -> Index:
    """The index of these options, built at once from their scaled values [C, D]."""
    buckets = _FIRST_BUCKETS
    # A bucket is half full at least.
    while buckets < 2 * len(options) // BUCKET + 2:
        buckets *= 2
    index = _allocate(buckets, scaled.shape[1])
    _build(index, scaled, 0, options.copy())
    return index


def with_room(index: Index) -> Index:
    """The index, or one of twice its size if there is little room left for more options."""
    buckets = len(index.buckets)
    if index.heads[_ROOM] > buckets // 8:
        return index
    grown = _allocate(2 * buckets, index.points.shape[1])
    for old, new in zip(index[1:], grown[1:], strict=True):
        new[: len(old)] = old
    grown.heads[:] = index.heads
    grown.heads[_ROOM] += buckets
    return grown


def _allocate(buckets: int, n_features: int) -> Index:
    return Index(
        heads=np.array([buckets, 1, 0, NONE, NONE], np.int64),
        nodes=np.zeros(2 * buckets, _NODE),
        boxes=np.zeros((2 * buckets, n_features, 2)),
        buckets=np.zeros(buckets, _BUCKET),
        points=np.zeros((buckets, n_features, BUCKET)),
        ids=np.zeros((buckets, BUCKET), np.int32),
        waiting=np.zeros(buckets, np.int32),
        bounds=np.zeros(buckets),
        gaps=np.zeros(BUCKET),
    )


@compiled_apart
def index_option(index: Index, scaled: NDArray[np.float64], option: int) -> None:
    """Adds an option at its scaled value; `with_room` must have been asked before."""
    node, rebuilt = 0, NONE
    while True:
        for d in range(scaled.shape[1]):
            value = scaled[option, d]
            index.boxes[node, d, 0] = min(index.boxes[node, d, 0], value)
            index.boxes[node, d, 1] = max(index.boxes[node, d, 1], value)
        index.nodes["count"][node] += 1
        if index.nodes["axis"][node] < 0:
            break
        if rebuilt < 0 and index.nodes["count"][node] >= index.nodes["review"][node]:
            index.nodes["review"][node] = _next_review(index.nodes["count"][node])
            child = index.nodes["below"][node]
            larger = max(index.nodes["count"][child], index.nodes["count"][child + 1])
            if larger > _LOPSIDED * index.nodes["count"][node]:
                rebuilt = node
        node = _side(index, scaled, option, node)
    if rebuilt < 0 and index.buckets["fill"][index.nodes["below"][node]] == BUCKET:
        if _are_alike(index, node):
            _chain_bucket(index, node)
        else:
            rebuilt = node
    if rebuilt < 0:
        _put(index, scaled, index.nodes["below"][node], option)
    else:
        options = np.empty(index.nodes["count"][rebuilt], np.int64)
        options[_release(index, rebuilt, options)] = option
        _build(index, scaled, rebuilt, options)


@compiled
def forget_option(index: Index, scaled: NDArray[np.float64], option: int) -> None:
    """Takes out an option that was added at this scaled value."""
    node = 0
    while True:
        index.nodes["count"][node] -= 1
        if index.nodes["axis"][node] < 0:
            break
        node = _side(index, scaled, option, node)
    bucket = index.nodes["below"][node]
    while True:
        last = index.buckets["fill"][bucket] - 1
        for n in range(last + 1):
            if index.ids[bucket, n] == option:
                index.ids[bucket, n] = index.ids[bucket, last]
                index.points[bucket, :, n] = index.points[bucket, :, last]
                index.buckets["fill"][bucket] = last
                return
        bucket = index.buckets["next"][bucket]


@compiled
def _side(index: Index, scaled: NDArray[np.float64], option: int, node: int) -> int:
    """The child of a node that an option belongs to."""
    is_second = scaled[option, index.nodes["axis"][node]] >= index.nodes["split"][node]
    return index.nodes["below"][node] + (1 if is_second else 0)


@compiled
def _are_alike(index: Index, node: int) -> bool:
    """Whether no feature tells a node's options apart."""
    for d in range(index.boxes.shape[1]):
        if index.boxes[node, d, 0] < index.boxes[node, d, 1]:
            return False
    return True


@compiled
def _next_review(count: int) -> int:
    return count + count // 2 + 1


@compiled
def _put(index: Index, scaled: NDArray[np.float64], bucket: int, option: int) -> None:
    place = index.buckets["fill"][bucket]
    index.buckets["fill"][bucket] += 1
    index.ids[bucket, place] = option
    for d in range(scaled.shape[1]):
        index.points[bucket, d, place] = scaled[option, d]


@compiled
def _release(index: Index, top: int, options: NDArray[np.int64]) -> int:
    """Frees all that is below a node; writes its options and returns how many."""
    found = 0
    index.waiting[0] = top
    height = 1
    while height > 0:
        height -= 1
        node = index.waiting[height]
        below = index.nodes["below"][node]
        if index.nodes["axis"][node] < 0:
            while below >= 0:
                for n in range(index.buckets["fill"][below]):
                    options[found] = index.ids[below, n]
                    found += 1
                following = index.buckets["next"][below]
                index.buckets["next"][below] = index.heads[_FREE_BUCKET]
                index.heads[_FREE_BUCKET] = below
                index.heads[_ROOM] += 1
                below = following
        else:
            index.waiting[height] = below
            index.waiting[height + 1] = below + 1
            height += 2
            # What is below the pair is still to be read, its counts are not.
            index.nodes["count"][below] = index.heads[_FREE_PAIR]
            index.heads[_FREE_PAIR] = below
    return found


@compiled_long
def _build(index: Index, scaled: NDArray[np.float64], top: int, options: NDArray[np.int64]) -> None:
    """Builds the tree of these options, which it sorts, below a node that has nothing below."""
    spare = index.heads[_ROOM] - _buckets_for(options.shape[0])
    index.nodes["count"][top] = options.shape[0]
    index.waiting[0] = top
    height, done = 1, 0
    while height > 0:
        height -= 1
        node = index.waiting[height]
        count = int(index.nodes["count"][node])
        own = options[done : done + count]
        axis = _fit_box(index, scaled, node, own)
        if count <= BUCKET or spare < 1 or _are_alike(index, node):
            _fill_leaf(index, scaled, node, own)
            done += count
            continue
        values = np.empty(count)
        for n in range(count):
            values[n] = scaled[own[n], axis]
        order = np.argsort(values)
        own[:] = own[order]
        values = values[order]
        middle = _boundary(values)
        child = index.heads[_FREE_PAIR]
        if child >= 0:
            index.heads[_FREE_PAIR] = index.nodes["count"][child]
        else:
            child = index.heads[_NODES]
            index.heads[_NODES] += 2
        index.nodes["axis"][node] = axis
        index.nodes["split"][node] = values[middle]
        index.nodes["below"][node] = child
        index.nodes["review"][node] = _next_review(count)
        index.nodes["count"][child], index.nodes["count"][child + 1] = middle, count - middle
        spare -= _buckets_for(middle) + _buckets_for(count - middle) - _buckets_for(count)
        # The first child on top: `own` is then always what comes next in `options`.
        index.waiting[height] = child + 1
        index.waiting[height + 1] = child
        height += 2


@compiled
def _buckets_for(count: int) -> int:
    """Buckets that a leaf of so many options has."""
    return max((count + BUCKET - 1) // BUCKET, 1)


@compiled
def _fit_box(
    index: Index, scaled: NDArray[np.float64], node: int, options: NDArray[np.int64]
) -> int:
    """Sets a node's box; returns the feature in which it is widest."""
    widest, axis = -1.0, 0
    for d in range(scaled.shape[1]):
        least, greatest = np.inf, -np.inf
        for option in options:
            least = min(least, scaled[option, d])
            greatest = max(greatest, scaled[option, d])
        index.boxes[node, d, 0], index.boxes[node, d, 1] = least, greatest
        if greatest - least > widest:
            widest, axis = greatest - least, d
    return axis


@compiled
def _boundary(values: NDArray[np.float64]) -> int:
    """Where sorted values, not all equal, are best halved without parting equal ones."""
    middle = values.shape[0] // 2
    before, after = middle, middle
    while before > 0 and values[before - 1] == values[middle]:
        before -= 1
    while after < values.shape[0] and values[after] == values[middle]:
        after += 1
    is_before_nearer = after == values.shape[0] or middle - before <= after - middle
    return before if before > 0 and is_before_nearer else after


@compiled
def _fill_leaf(
    index: Index, scaled: NDArray[np.float64], node: int, options: NDArray[np.int64]
) -> None:
    """Makes a node a leaf of these options."""
    index.nodes["axis"][node] = NONE
    index.nodes["below"][node] = NONE
    _chain_bucket(index, node)
    for option in options:
        if index.buckets["fill"][index.nodes["below"][node]] == BUCKET:
            _chain_bucket(index, node)
        _put(index, scaled, index.nodes["below"][node], option)


@compiled
def _chain_bucket(index: Index, leaf: int) -> None:
    """Gives a leaf an empty bucket, in front of those it has."""
    bucket = index.heads[_FREE_BUCKET]
    if bucket >= 0:
        index.heads[_FREE_BUCKET] = index.buckets["next"][bucket]
    else:
        bucket = index.heads[_BUCKETS]
        index.heads[_BUCKETS] += 1
    index.heads[_ROOM] -= 1
    index.buckets["fill"][bucket] = 0
    index.buckets["next"][bucket] = index.nodes["below"][leaf]
    index.nodes["below"][leaf] = bucket


def check_index(index: Index, scaled: NDArray[np.float64], is_alive: NDArray[np.bool_]) -> None:
    """Asks the index whether it holds just the living options, each where it belongs.

    Raises:
        AssertionError: Naming the first invariant that does not hold.
    """
    options = np.flatnonzero(is_alive)
    buckets: list[int] = []
    stack = [(0, options)]
    while stack:
        node, below = stack.pop()
        assert index.nodes["count"][node] == len(below), f"Node {node} miscounts its options."
        values = scaled[below]
        assert (index.boxes[node, :, 0] <= values).all(), f"An option lies outside of {node}."
        assert (index.boxes[node, :, 1] >= values).all(), f"An option lies outside of {node}."
        child = int(index.nodes["below"][node])
        if index.nodes["axis"][node] >= 0:
            is_second = values[:, index.nodes["axis"][node]] >= index.nodes["split"][node]
            stack += [(child, below[~is_second]), (child + 1, below[is_second])]
            continue
        kept: list[int] = []
        while child != NONE:
            n = index.buckets["fill"][child]
            kept += index.ids[child, :n].tolist()
            np.testing.assert_array_equal(
                index.points[child, :, :n].T, scaled[kept[len(kept) - n :]]
            )
            buckets.append(child)
            child = int(index.buckets["next"][child])
        assert sorted(kept) == below.tolist(), f"Leaf {node} keeps other options than its own."
    assert len(set(buckets)) == len(buckets), "A bucket is in two leaves."
    assert len(buckets) + index.heads[_ROOM] == len(index.buckets), "A bucket is lost."
