"""A forest as the arrays that are drawn, and the layouts they come from."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.figures.palette import UNTRIED, action_colors
from ao2viz.layout.discs import Layout, has_regrown, lay_out
from ao2viz.ui.view import ForestKey

_ROOM = 1.7  # A forest that grows is arranged with so many times the places it needs.
_GLIDE_S = 0.9  # A regrown forest takes so long to rearrange itself …
_GLIDE_LIMIT = 6_000  # … unless it is so big that sending every moment of it takes too long.
# A growing forest is laid out again only after this many times as long as the last time took, so
# that the screen stays quick however big the forest is.
_REST = 5.0
_PICK_RADIUS = 1.2  # Clicks this close to an option count; options are at least 1 apart.


@dataclass(frozen=True, eq=False)
class Picture:
    """What is drawn of a forest; `N` counts options (cleansed ones have size 0)."""

    layout: Layout
    positions: NDArray[np.float32]  # [N, 3] all on the plane z = 0.
    colors: NDArray[np.uint8]  # [N, 3]
    sizes: NDArray[np.float32]  # [N] radii.
    edges: NDArray[np.float32]  # [E, 2, 3] from parent to child.
    edge_ends: NDArray[np.int64]  # [E, 2] their ids.

    def position_of(self, option: int) -> NDArray[np.float32] | None:
        """Where an option stands [3]; None if it is not drawn."""
        if 0 <= option < len(self.sizes) and self.sizes[option] > 0:
            return self.positions[option]
        return None

    def pick(self, origin: tuple[float, ...], direction: tuple[float, ...]) -> int:
        """The option that a ray from the camera meets; NO_OPTION if it meets none."""
        if len(origin) != 3 or len(direction) != 3:
            return NO_OPTION
        ray = np.array([origin, direction], np.float64)
        if not np.isfinite(ray).all() or ray[1, 2] * ray[0, 2] >= 0:
            return NO_OPTION  # Looking away from the plane, or no ray at all.
        hit = ray[0, :2] - ray[1, :2] * ray[0, 2] / ray[1, 2]
        gaps = np.hypot(*(self.positions[:, :2] - hit).T)
        gaps[self.sizes == 0] = np.inf
        if len(gaps) == 0 or gaps.min() > _PICK_RADIUS:
            return NO_OPTION
        return int(np.argmin(gaps))

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of what is drawn."""
        if len(self.layout.roots) == 0:
            return -10.0, 10.0, -10.0, 10.0
        centres, radii = self.layout.centres, self.layout.radii[:, None]
        low, high = (centres - radii).min(axis=0), (centres + radii).max(axis=0)
        return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def draw(view: ForestView, layout: Layout, spec: TaskSpec) -> Picture:
    """The arrays of a forest that has been laid out."""
    drawn = ~np.isnan(layout.positions[:, 0])
    positions = np.zeros((len(drawn), 3), np.float32)
    positions[drawn, :2] = layout.positions[drawn]
    colors = action_colors(spec.n_actions, is_ordered=spec.action_grid is not None)
    visits = view.visits[: len(drawn)].sum(axis=1)
    children = np.flatnonzero(drawn & (view.parents[: len(drawn)] != NO_OPTION))
    parents = view.parents[children]
    return Picture(
        layout=layout,
        positions=positions,
        colors=np.where(
            visits[:, None] > 0,
            colors[view.best_actions[: len(drawn)]],
            np.array(UNTRIED, np.uint8),
        ).astype(np.uint8),
        sizes=np.where(drawn, np.clip(0.24 + 0.045 * np.log2(1 + visits), 0, 0.46), 0).astype(
            np.float32
        ),
        edges=np.stack([positions[parents], positions[children]], axis=1),
        edge_ends=np.column_stack([parents, children]),
    )


@dataclass(frozen=True, eq=False)
class _Hung:
    """A picture, what it was drawn from, and when it may be drawn again."""

    picture: Picture
    view: ForestView
    rest_until: float


class Gallery:
    """Pictures of the forests on screen; each is laid out once, however many browsers watch."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._hung: dict[ForestKey, _Hung] = {}
        self._glides: dict[ForestKey, _Glide] = {}

    def get(self, key: ForestKey, view: ForestView, spec: TaskSpec) -> Picture:
        """The picture of a forest as it is now, or a moment ago if it grows fast.

        Options of a growing forest stay where they are. Only when it regrows as a whole do they
        glide to a fresh arrangement.
        """
        hung, began = self._hung.get(key), self._clock()
        if hung is None or (hung.view is not view and began >= hung.rest_until):
            hung = self._hang(key, view, spec, hung)
        glide = self._glides.get(key)
        if glide is None:
            return hung.picture
        if began >= glide.ends_at:
            del self._glides[key]
            return hung.picture
        return _between(glide, hung.picture, began)

    def _hang(
        self, key: ForestKey, view: ForestView, spec: TaskSpec, hung: "_Hung | None"
    ) -> "_Hung":
        began = self._clock()
        room = _ROOM if key[0] == "run" else 1.0
        if hung is None:
            layout = lay_out(view, None, room)
        elif hung.view.revision == view.revision:
            layout = hung.picture.layout
        elif len(hung.picture.layout.roots) == 0 or has_regrown(hung.view, view):
            layout = lay_out(view, None, room)
            if 0 < len(view) <= _GLIDE_LIMIT and len(hung.picture.layout.roots):
                self._glides[key] = _Glide(hung.picture.layout, began, began + _GLIDE_S)
        else:
            layout = lay_out(view, hung.picture.layout)
        picture = draw(view, layout, spec)
        ended = self._clock()
        new = self._hung[key] = _Hung(picture, view, ended + _REST * (ended - began))
        return new

    def keep_only(self, keys: set[ForestKey]) -> None:
        """Forgets forests that no browser shows any more."""
        for gone in self._hung.keys() - keys:
            del self._hung[gone]
            self._glides.pop(gone, None)


def _between(glide: "_Glide", picture: Picture, now: float) -> Picture:
    """The picture part of the way from an old layout to its own."""
    progress = (now - glide.began) / (glide.ends_at - glide.began)
    eased = progress * progress * (3 - 2 * progress)
    old, new = glide.start.positions, picture.layout.positions
    both = np.flatnonzero(~np.isnan(old[: len(new), 0]) & ~np.isnan(new[: len(old), 0]))
    positions = new.copy()
    positions[both] = old[both] + (new[both] - old[both]) * eased
    roots = picture.layout.roots
    layout = replace(picture.layout, positions=positions, centres=positions[roots])
    points = picture.positions.copy()
    points[both, :2] = positions[both]
    edges = np.stack([points[picture.edge_ends[:, 0]], points[picture.edge_ends[:, 1]]], axis=1)
    return replace(picture, layout=layout, positions=points, edges=edges)


@dataclass(frozen=True, eq=False)
class _Glide:
    """A move of all options from one layout to another."""

    start: Layout
    began: float
    ends_at: float
