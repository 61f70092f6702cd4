"""A forest as the arrays that are drawn: where options stand, how big they are, what colour."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.figures.coloring import Shades, shade
from ao2viz.layout.cones import find_heights
from ao2viz.layout.discs import Layout, schemas_of
from ao2viz.layout.state_space import Axes
from ao2viz.ui.look import Arrangement, Look

Ground = Layout | Axes
"""What places come from: discs side by side, or features as axes."""

_PICK_RADIUS = 1.2  # Clicks this close to an option count; options are at least 1 apart.
_FOLDED_SIZE = 1.15  # The root that stands for a whole schema is this big.
_BALL_ROOM = 1.5
_BALL_GROWTH = 1.4  # Seen from farther away than a dot from above.
_CELLS = 14  # Along each axis, to tell which parts of the state space are empty.


@dataclass(frozen=True, eq=False)
class Picture:
    """What is drawn of a forest; `N` counts options, cleansed and hidden ones have size 0."""

    ground: Ground
    is_flat: bool  # All on the plane z = 0, to be seen from above.
    positions: NDArray[np.float32]  # [N, 3] also of hidden options; 0 where cleansed.
    stands: NDArray[np.bool_]  # [N] has a place, drawn or not.
    shades: Shades
    sizes: NDArray[np.float32]  # [N] radii.
    edges: NDArray[np.float32]  # [E, 2, 3] from parent to child; none in the state space.
    edge_ends: NDArray[np.int64]  # [E, 2] their ids.
    schemas: NDArray[np.int64]  # [N] the root of each option.
    folded: NDArray[np.int64]  # [F] roots that stand for their whole schema.
    n_hidden: int  # Living options that are not drawn.
    outline: NDArray[np.float64]  # [K, 4] balls x, y, z, radius that hold what is drawn.

    @property
    def colors(self) -> NDArray[np.uint8]:
        """One for each option, [N, 3]."""
        return self.shades.colors

    @property
    def axes(self) -> Axes | None:
        """The axes, if this is the state space."""
        return self.ground if isinstance(self.ground, Axes) else None

    @property
    def discs(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Centres [S, 2] and radii [S] of the discs that are drawn; none unless seen flat."""
        if isinstance(self.ground, Layout) and self.is_flat:
            return self.ground.centres, self.ground.radii * self.stands[self.ground.roots]
        return np.empty((0, 2)), np.empty(0)

    def position_of(self, option: int) -> NDArray[np.float32] | None:
        """Where an option stands [3], drawn or not; None if it has no place."""
        if 0 <= option < len(self.stands) and self.stands[option]:
            return self.positions[option]
        return None

    def pick(self, origin: tuple[float, ...], direction: tuple[float, ...]) -> int:
        """The drawn option that a ray from the camera meets; NO_OPTION if it meets none."""
        if len(origin) != 3 or len(direction) != 3:
            return NO_OPTION
        ray = np.array([origin, direction], np.float64)
        length = float(np.linalg.norm(ray[1]))
        if not np.isfinite(ray).all() or length == 0 or len(self.sizes) == 0:
            return NO_OPTION
        along = ray[1] / length
        toward = self.positions - ray[0]
        ahead = toward @ along
        gaps = np.linalg.norm(toward - ahead[:, None] * along, axis=1)
        gaps[(self.sizes == 0) | (ahead <= 0)] = np.inf
        near = int(np.argmin(gaps))
        return near if gaps[near] <= max(_PICK_RADIUS, self.sizes[near]) else NO_OPTION

    def edges_of_schema(self, schema: int, view: ForestView) -> NDArray[np.float32]:
        """[E, 2, 3] all edges of one schema, wherever its options stand."""
        n = len(self.stands)
        children = np.flatnonzero(
            (self.schemas == schema) & self.stands & (view.parents[:n] != NO_OPTION)
        )
        both = [self.positions[view.parents[children]], self.positions[children]]
        return np.stack(both, axis=1)


def draw(
    view: ForestView,
    ground: Ground,
    spec: TaskSpec,
    look: Look,
    agreement: NDArray[np.float64] | None = None,
) -> Picture:
    """The arrays of a forest whose ground is known; `agreement` only for that colouring."""
    positions, stands = _places(view, ground, look)
    n = len(stands)
    schemas = schemas_of(view)[:n]
    shown = stands.copy()
    if look.deepest is not None:
        shown &= view.depths[:n] <= look.deepest
    is_root = view.parents[:n] == NO_OPTION
    folded = np.array(sorted(look.folded), np.int64)
    folded = folded[(folded >= 0) & (folded < n)]
    folded = folded[stands[folded] & is_root[folded]]
    shown &= is_root | ~np.isin(schemas, folded)
    visits = view.visits[:n].sum(axis=1)
    sizes = np.where(shown, np.clip(0.24 + 0.045 * np.log2(1 + visits), 0, 0.46), 0)
    sizes *= 1.0 if look.is_flat else _BALL_GROWTH
    sizes[folded] = _FOLDED_SIZE
    edge_ends = np.empty((0, 2), np.int64)
    if isinstance(ground, Layout):
        children = np.flatnonzero(shown & ~is_root)
        edge_ends = np.column_stack([view.parents[children], children])
    return Picture(
        ground=ground,
        is_flat=look.is_flat,
        positions=positions,
        stands=stands,
        shades=shade(view, spec, look.coloring, agreement),
        sizes=sizes.astype(np.float32),
        edges=np.stack([positions[edge_ends[:, 0]], positions[edge_ends[:, 1]]], axis=1),
        edge_ends=edge_ends,
        schemas=schemas,
        folded=folded,
        n_hidden=int(np.count_nonzero(view.is_alive)) - int(np.count_nonzero(shown)),
        outline=_outline(ground, positions, stands),
    )


def _places(
    view: ForestView, ground: Ground, look: Look
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    if isinstance(ground, Axes):
        stands = np.array(view.is_alive)
        return np.where(stands[:, None], ground.place(view.values), 0).astype(np.float32), stands
    # The ground may have places for options that are gone, or still to come.
    stands = ~np.isnan(ground.positions[:, 0]) & view.is_alive[: len(ground.positions)]
    positions = np.zeros((len(stands), 3), np.float32)
    positions[stands, :2] = ground.positions[stands]
    if look.arrangement is Arrangement.CONES:
        positions[stands, 2] = find_heights(view.depths[: len(stands)][stands])
    return positions, stands


def _outline(
    ground: Ground, positions: NDArray[np.float32], stands: NDArray[np.bool_]
) -> NDArray[np.float64]:
    if isinstance(ground, Layout):
        if len(ground.roots) == 0:
            return np.array([[0.0, 0.0, 0.0, 10.0]])
        if not positions[:, 2].any():
            flat = np.zeros(len(ground.radii))
            return np.column_stack([ground.centres, flat, ground.radii])
        return np.column_stack([positions[stands], np.full(int(stands.sum()), _BALL_ROOM)])
    # The cells of the box that hold options, and the ends of the axes with room for words.
    low, high = ground.box
    size = np.maximum(high - low, 1e-9)
    cells = np.unique(((positions[stands] - low) / size * _CELLS).astype(np.int64), axis=0)
    middles = low + (cells + 0.5) * size / _CELLS * (size > 1e-6)
    radius = float(size.max()) / _CELLS
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [low[0], high[1]]])
    ends = np.column_stack([corners, np.full(3, low[2]), np.full(3, 1.2 * radius)])
    top = np.array([[low[0], low[1], high[2], 1.2 * radius]])
    inner = np.column_stack([middles, np.full(len(middles), radius)])
    return np.concatenate([inner, ends, top])
