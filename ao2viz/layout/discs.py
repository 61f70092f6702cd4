"""A forest as packed discs: one disc a schema, its root in the middle, the biggest in the centre.

`lay_out(view)` arranges a whole forest afresh; `lay_out(view, previous)` keeps every option where
it was and finds room for the new ones; `has_regrown` says when the first is the better choice.
Units are arbitrary: no two options are closer than `SPACING` in either case.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.layout.growth import Field, Rings, ideal_spot, place_root
from ao2viz.layout.packing import pack_circles
from ao2viz.layout.radial import SPACING, arrange_discs

_RIM = 1.2  # From the outermost option to the edge of its disc.
_BETWEEN = 1.6  # From the edge of a disc to the next.
_REGROWN = 0.25  # Share of the options with new parents.
_AT_A_TIME = 512  # Discs whose distances to all others are in memory at once.


@dataclass(frozen=True, eq=False)
class Layout:
    """Where every option stands. `N` counts options, `S` schemas."""

    positions: NDArray[np.float64]  # [N, 2] NaN once cleansed.
    roots: NDArray[np.int64]  # [S] ids, in order of age.
    centres: NDArray[np.float64]  # [S, 2] where the roots stand.
    radii: NDArray[np.float64]  # [S] far enough to hold every option of the schema.

    @property
    def extent(self) -> float:
        """Half the side of the smallest square around the origin that holds every disc."""
        if len(self.roots) == 0:
            return 10 * SPACING
        return float((np.abs(self.centres).max(axis=1) + self.radii).max())


EMPTY = Layout(np.empty((0, 2)), np.empty(0, np.int64), np.empty((0, 2)), np.empty(0))
"""Nothing laid out yet: growing from here leaves room between schemas."""


def lay_out(view: ForestView, previous: Layout | None = None, room: float = 1.0) -> Layout:
    """Places every living option; those of `previous` stay exactly where they are.

    Without `previous` everything is arranged afresh: as compactly as can be, or with `room` (at
    least 1) times as many places as there are options, so that a forest can grow in its form.
    """
    if previous is None:
        return _arrange(view, room)
    positions = np.full((len(view.parents), 2), np.nan)
    kept = min(len(previous.positions), len(positions))
    positions[:kept] = previous.positions[:kept]
    positions[~view.is_alive] = np.nan
    new = np.flatnonzero(view.is_alive & np.isnan(positions[:, 0]))
    if len(new):
        extent = previous.extent + 4 * np.sqrt(len(new)) + 30
        while not _grow(view, positions, new, extent):
            positions[new] = np.nan
            extent *= 1.6
    return _finish(view, positions)


def has_regrown(before: ForestView, now: ForestView) -> bool:
    """Whether so many options got other parents at once that the old picture means little.

    A change of attention rebuilds the forest from its options; growth and cleansing do not.
    """
    n = min(len(before.parents), len(now.parents))
    both = before.is_alive[:n] & now.is_alive[:n]
    moved = both & (before.parents[:n] != now.parents[:n])
    return bool(moved.sum() > _REGROWN * both.sum())


def has_crowded(layout: Layout) -> bool:
    """Whether discs have run into one another, for want of room where nothing may move."""
    for first in range(0, len(layout.roots), _AT_A_TIME):
        some = slice(first, first + _AT_A_TIME)
        gaps = np.hypot(*(layout.centres[some, None] - layout.centres[None]).transpose(2, 0, 1))
        needed = layout.radii[some, None] + layout.radii[None]
        if np.count_nonzero(gaps < needed) > len(gaps):  # Every disc meets itself.
            return True
    return False


def schemas_of(view: ForestView) -> NDArray[np.int64]:
    """[N] the root of each option; NO_OPTION once cleansed."""
    schemas = np.where(view.is_alive, np.arange(len(view.parents)), NO_OPTION)
    for depth in range(1, int(view.depths.max(initial=0)) + 1):
        rows = np.flatnonzero(view.is_alive & (view.depths == depth))
        schemas[rows] = schemas[view.parents[rows]]
    return schemas


def _arrange(view: ForestView, room: float) -> Layout:
    positions = np.full((len(view.parents), 2), np.nan)
    alive = np.flatnonzero(view.is_alive)
    if len(alive) == 0:
        return _finish(view, positions)
    roots, schemas = np.unique(schemas_of(view)[alive], return_inverse=True)
    row_of = np.full(len(view.parents) + 1, NO_OPTION)  # The last cell answers for NO_OPTION.
    row_of[alive] = np.arange(len(alive))
    offsets, radii = arrange_discs(row_of[view.parents[alive]], view.depths[alive], schemas, room)
    # A schema of one option may become one of many; give even small ones room for a first ring.
    padded = radii + _RIM + (_BETWEEN if room == 1 else 3 * _BETWEEN * room) / 2
    biggest_first = np.argsort(-padded, kind="stable")
    centres = np.empty((len(roots), 2))
    centres[biggest_first] = pack_circles(padded[biggest_first])
    positions[alive] = centres[schemas] + offsets
    return _finish(view, positions)


def _grow(
    view: ForestView, positions: NDArray[np.float64], new: NDArray[np.int64], extent: float
) -> bool:
    """Writes the places of new options into `positions`; False if the field was too small."""
    field = Field(extent)
    schemas = schemas_of(view)
    placed = np.flatnonzero(~np.isnan(positions[:, 0]))
    field.put(positions[placed])
    roots = np.flatnonzero(view.is_alive & (view.parents == NO_OPTION))
    is_new_root = np.isnan(positions[roots, 0])
    reaches = _reaches(positions, schemas, placed, len(view.parents))
    known = list(roots[~is_new_root])
    for root in roots[is_new_root]:
        spot = place_root(positions[known], reaches[known], field)
        if spot is None:
            return False
        positions[root] = spot
        field.put(spot[None])
        known.append(root)
    children = new[view.parents[new] != NO_OPTION]
    for schema in np.unique(schemas[children]):
        members = children[schemas[children] == schema]
        others = roots[roots != schema]
        away = np.hypot(*(positions[others] - positions[schema]).T) - reaches[others]
        # So far its options may stand without its disc meeting another.
        within = float(away.min(initial=np.inf)) - 2 * _RIM
        if not _grow_schema(view, positions, schemas, int(schema), members, field, within):
            return False
        placed = members[~np.isnan(positions[members, 0])]
        farthest = np.hypot(*(positions[placed] - positions[schema]).T).max(initial=0)
        reaches[schema] = max(float(reaches[schema]), float(farthest))
    return True


def _grow_schema(
    view: ForestView,
    positions: NDArray[np.float64],
    schemas: NDArray[np.int64],
    schema: int,
    members: NDArray[np.int64],
    field: Field,
    within: float,
) -> bool:
    centre = positions[schema].copy()
    old = np.flatnonzero((schemas == schema) & ~np.isnan(positions[:, 0]))
    distances = np.hypot(*(positions[old] - centre).T)
    total = np.zeros(int(view.depths[members].max()) + 1)
    count = np.zeros(len(total), np.int64)
    shallow = view.depths[old] < len(total)
    np.add.at(total, view.depths[old][shallow], distances[shallow])
    np.add.at(count, view.depths[old][shallow], 1)
    reach = max(float(distances.max()), 6.0) + 2 + np.sqrt(len(members))
    rings = Rings(centre, reach, field)
    siblings = np.bincount(view.parents[old][view.parents[old] >= 0], minlength=len(positions))
    # Parents come before their children, the oldest first.
    for option in members[np.lexsort((members, view.depths[members]))]:
        parent, depth = int(view.parents[option]), int(view.depths[option])
        ring = total[depth] / count[depth] if count[depth] else None
        ideal = ideal_spot(centre, positions[parent], int(siblings[parent]), depth, ring)
        while (spot := rings.take_nearest(ideal, within)) is None:
            if (reach := reach * 1.3) > 3 * field.extent:
                return False
            rings = Rings(centre, reach, field)
        positions[option] = spot
        siblings[parent] += 1
        if count[depth] < 3:  # The first few say where the ring is; later ones only fill it.
            total[depth] += np.hypot(*(spot - centre))
            count[depth] += 1
        field.put(spot[None])
    return True


def _reaches(
    positions: NDArray[np.float64],
    schemas: NDArray[np.int64],
    placed: NDArray[np.int64],
    n_rows: int,
) -> NDArray[np.float64]:
    """[N] how far the placed options of each schema are from its root; 0 where not a root."""
    reaches = np.zeros(n_rows)
    away = np.hypot(*(positions[placed] - positions[schemas[placed]]).T)
    np.maximum.at(reaches, schemas[placed], np.nan_to_num(away))
    return reaches


def _finish(view: ForestView, positions: NDArray[np.float64]) -> Layout:
    placed = np.flatnonzero(view.is_alive)
    roots = np.flatnonzero(view.is_alive & (view.parents == NO_OPTION))
    reaches = _reaches(positions, schemas_of(view), placed, len(view.parents))
    positions.flags.writeable = False
    return Layout(positions, roots, positions[roots], reaches[roots] + _RIM)
