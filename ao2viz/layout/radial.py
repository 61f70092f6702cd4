"""Trees as discs: the root in the middle, one band of rings for each depth."""

import numpy as np
from numpy.typing import NDArray

SPACING = 1.0
"""No two options stand closer than this."""

_RING_GAP = 1.04  # Between the rings of one band; at least SPACING.
_FILL = 0.78  # Share of a band's places that is planned for; the rest lets families keep together.
_APART = 1e4  # Farther than any angle: keeps schemas apart where all are handled in one sweep.


def band_gap(deepest: int) -> float:
    """How far apart the bands of two depths are: wide in shallow trees, tight in deep ones."""
    return float(np.clip(26.0 / max(deepest, 1), 1.15, 2.6))


def arrange_discs(
    parents: NDArray[np.int64],
    depths: NDArray[np.int64],
    schemas: NDArray[np.int64],
    room: float = 1.0,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Offsets [M, 2] from each option's root, and the radius [S] of each schema's disc.

    Rows are the living options; `parents` holds rows (-1 at a root), `schemas` numbers the trees
    from 0, `room` is how many times more places there are than options need.

    Every subtree would like its own interval of angles, as wide as its share of leaves; within a
    depth options are then pushed apart just enough, keeping their order, so edges of one depth
    never cross. A crowded depth gets several rings, which its options take in turn.
    """
    n_schemas = int(schemas.max()) + 1
    by_depth = [np.flatnonzero(depths == d) for d in range(int(depths.max()) + 1)]
    inner, rings = _plan_bands(depths, schemas, n_schemas, room)
    wished = _share_angles(parents, by_depth)
    angles, radii = wished.copy(), np.zeros(len(parents))
    for depth, at_depth in enumerate(by_depth[1:], start=1):
        row = at_depth[np.lexsort((at_depth, wished[at_depth], schemas[at_depth]))]
        schema = schemas[row]
        place = np.arange(len(row)) - np.searchsorted(schema, schema)
        n_rings = rings[schema, depth]
        arc = _arc(inner[schema, depth]) / n_rings
        n_peers = np.bincount(schema, minlength=n_schemas)[schema]
        # A band of k rings is dealt out in turn; k free places at the seam keep its ends apart.
        room = 2 * np.pi - (n_peers + n_rings) * arc
        slack = np.clip(wished[row] - place * arc, 0, room) + schema * _APART
        pushed_on = np.maximum.accumulate(slack)
        pulled_back = np.minimum.accumulate(slack[::-1])[::-1]
        angles[row] = (pushed_on + pulled_back) / 2 - schema * _APART + place * arc
        radii[row] = inner[schema, depth] + place % n_rings * _RING_GAP
    discs = np.zeros(n_schemas)
    np.maximum.at(discs, schemas, radii)
    turned = angles + np.pi / 2
    return radii[:, None] * np.column_stack([np.cos(turned), np.sin(turned)]), discs


def _share_angles(
    parents: NDArray[np.int64], by_depth: list[NDArray[np.int64]]
) -> NDArray[np.float64]:
    """[M] the middle of each option's interval, children splitting their parent's by leaves."""
    leaves = np.ones(len(parents))
    for at_depth in by_depth[:0:-1]:
        held = np.bincount(parents[at_depth], weights=leaves[at_depth], minlength=len(parents))
        leaves = np.where(held > 0, held, leaves)
    starts, spans = np.zeros(len(parents)), np.full(len(parents), 2 * np.pi)
    for at_depth in by_depth[1:]:
        order = at_depth[np.argsort(parents[at_depth], kind="stable")]
        parent = parents[order]
        ends = np.cumsum(leaves[order])
        is_first = np.r_[True, parent[1:] != parent[:-1]]
        before = (ends - leaves[order])[is_first][np.cumsum(is_first) - 1]
        stretch = spans[parent] / leaves[parent]
        starts[order] = starts[parent] + (ends - leaves[order] - before) * stretch
        spans[order] = leaves[order] * stretch
    return starts + spans / 2


def _plan_bands(
    depths: NDArray[np.int64], schemas: NDArray[np.int64], n_schemas: int, room: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Innermost radius and number of rings of each schema's depths, both [S, depths]."""
    n_depths = int(depths.max()) + 1
    counts = np.zeros((n_schemas, n_depths), np.int64)
    np.add.at(counts, (schemas, depths), 1)
    inner, rings = np.zeros((n_schemas, n_depths)), np.ones((n_schemas, n_depths), np.int64)
    deepest = np.max(np.where(counts > 0, np.arange(n_depths), 0), axis=1)
    gaps = np.array([band_gap(int(d)) for d in deepest])
    edge = np.zeros(n_schemas)
    for depth in range(1, n_depths):
        inner[:, depth] = edge + gaps
        load = counts[:, depth] * _arc(inner[:, depth])
        rings[:, depth] = np.maximum(1, np.ceil(room * load / (2 * np.pi * _FILL)))
        edge = inner[:, depth] + (rings[:, depth] - 1) * _RING_GAP
    return inner, rings


def _arc(radius: NDArray[np.float64]) -> NDArray[np.float64]:
    """The angle between two options a little more than SPACING apart on a circle."""
    return 2 * np.arcsin(np.minimum(1.0, 0.5001 * SPACING / np.maximum(radius, SPACING)))
