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
from ao2viz.ui.detail import Detail, choose_roots, detail_for
from ao2viz.ui.look import Arrangement, Look

Ground = Layout | Axes
"""What places come from: discs side by side, or features as axes."""

_PICK_RADIUS = 1.2  # Clicks this close to an option count; options are at least 1 apart.
_FOLDED_SIZE = 1.15  # The root that stands for a whole schema is this big.
_BALL_ROOM = 1.5
_BALL_GROWTH = 1.4  # Seen from farther away than a dot from above.
_SYMBOL = 1 / 300  # A root that stands for a schema is so big, seen from afar: of the whole.
_MOST_BALLS = 5_000  # To hold a picture with depth; more options are held by cells of a grid, …
_FINE_CELLS = 40  # … so many along each axis.
_CELLS = 14  # Along each axis, to tell which parts of the state space are empty.


@dataclass(frozen=True, eq=False)
class Picture:
    """What is drawn of a forest; `N` counts options, cleansed and hidden ones have size 0."""

    ground: Ground
    detail: Detail
    drawn: NDArray[np.int64]  # [M] ids that have a shape or a dot, by age unless told otherwise.
    drawn_sizes: NDArray[np.float32]  # [M] radii of these; roots that stand for more are bigger.
    is_flat: bool  # All on the plane z = 0, to be seen from above.
    positions: NDArray[np.float32]  # [N, 3] also of hidden options; 0 where cleansed.
    stands: NDArray[np.bool_]  # [N] has a place, drawn or not.
    shades: Shades
    sizes: NDArray[np.float32]  # [N] radii.
    parents: NDArray[np.int64]  # [N] NO_OPTION at a root.
    depths: NDArray[np.int64]  # [N] 0 at a root.
    edges: NDArray[np.float32]  # [E, 2, 3] from parent to child; none in the state space.
    edge_ends: NDArray[np.int64]  # [E, 2] their ids.
    schemas: NDArray[np.int64]  # [N] the root of each option.
    folded: NDArray[np.int64]  # [F] roots that stand for their whole schema.
    n_hidden: int  # Living options that a person does not want to see.
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

    def pick(
        self,
        origin: tuple[float, ...],
        direction: tuple[float, ...],
        beside: NDArray[np.int64] | None = None,
    ) -> int:
        """The option that a ray from the camera meets; NO_OPTION if it meets none.

        `beside` are ids that are drawn over the picture.
        """
        if len(origin) != 3 or len(direction) != 3:
            return NO_OPTION
        ray = np.array([origin, direction], np.float64)
        length = float(np.linalg.norm(ray[1]))
        if not np.isfinite(ray).all() or length == 0 or len(self.drawn) == 0:
            return NO_OPTION
        along = ray[1] / length
        options, sizes = self.drawn, self.drawn_sizes
        if beside is not None:
            options, sizes = np.r_[beside, options], np.r_[self.sizes[beside], sizes]
        toward = self.positions[options] - ray[0]
        ahead = toward @ along
        gaps = np.linalg.norm(toward - ahead[:, None] * along, axis=1)
        gaps[(sizes == 0) | (ahead <= 0)] = np.inf
        near = int(np.argmin(gaps))
        is_met = gaps[near] <= max(_PICK_RADIUS, sizes[near])
        return int(options[near]) if is_met else NO_OPTION

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
    order: NDArray[np.int64] | None = None,
) -> Picture:
    """The arrays of a forest whose ground is known.

    Args:
        view: The forest.
        ground: Where options stand.
        spec: Names its actions.
        look: How it is seen.
        agreement: [N] only for that colouring.
        order: [N] in which options are drawn, if not by age.
    """
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
    sizes = sizes.astype(np.float32)
    edge_ends = np.empty((0, 2), np.int64)
    n_wanted = int(np.count_nonzero(shown))
    detail = detail_for(n_wanted)
    outline = _outline(ground, positions, stands)
    drawn = np.arange(n) if order is None else order[order < n]
    drawn_sizes = sizes[drawn]
    if detail is Detail.ROOTS:
        drawn = choose_roots(np.flatnonzero(shown & is_root), schemas, shown)
        ends = outline[:, :3] + outline[:, 3:], outline[:, :3] - outline[:, 3:]
        symbol = float((ends[0].max(axis=0) - ends[1].min(axis=0)).max()) * _SYMBOL
        drawn_sizes = np.full(len(drawn), max(_FOLDED_SIZE, symbol), np.float32)
    if isinstance(ground, Layout) and detail is Detail.FULL:
        children = drawn[(shown & ~is_root)[drawn]]
        edge_ends = np.column_stack([view.parents[children], children])
    return Picture(
        ground=ground,
        detail=detail,
        drawn=drawn,
        drawn_sizes=drawn_sizes,
        is_flat=look.is_flat,
        positions=positions,
        stands=stands,
        shades=shade(view, spec, look.coloring, agreement, look.theme.palette),
        sizes=sizes,
        parents=view.parents[:n],
        depths=view.depths[:n],
        edges=np.stack([positions[edge_ends[:, 0]], positions[edge_ends[:, 1]]], axis=1),
        edge_ends=edge_ends,
        schemas=schemas,
        folded=folded,
        n_hidden=int(np.count_nonzero(view.is_alive)) - n_wanted,
        outline=outline,
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
        points = positions[stands].astype(np.float64)
        if len(points) > _MOST_BALLS:
            low, high = points.min(axis=0), points.max(axis=0)
            middles, cell = _cells(points, low, high, _FINE_CELLS)
            half = float(np.linalg.norm(cell)) / 2
            return np.column_stack([middles, np.full(len(middles), half + _BALL_ROOM)])
        return np.column_stack([points, np.full(len(points), _BALL_ROOM)])
    # The cells of the box that hold options, and the ends of the axes with room for words.
    low, high = ground.box
    middles, cell = _cells(positions[stands], low, high, _CELLS)
    radius = float(cell.max())
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [low[0], high[1]]])
    ends = np.column_stack([corners, np.full(3, low[2]), np.full(3, 1.2 * radius)])
    top = np.array([[low[0], low[1], high[2], 1.2 * radius]])
    inner = np.column_stack([middles, np.full(len(middles), radius)])
    return np.concatenate([inner, ends, top])


def _cells(
    points: NDArray, low: NDArray[np.float64], high: NDArray[np.float64], count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The middles [K, 3] of the cells of a box that hold points [M, 3], and a cell's size [3]."""
    size = np.maximum(high - low, 1e-9)
    steps = ((points - low) / size * count).astype(np.int64)
    numbers = np.unique(steps @ np.array([1, 4096, 4096**2]))
    cells = np.column_stack([numbers % 4096, numbers // 4096 % 4096, numbers // 4096**2])
    return low + (cells + 0.5) * size / count * (size > 1e-6), size / count
