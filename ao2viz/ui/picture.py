"""A forest as the arrays that are drawn, and the layouts they come from."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.figures.palette import UNTRIED, action_colors
from ao2viz.layout.discs import EMPTY, Layout, lay_out
from ao2viz.ui.view import ForestKey

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

    def position_of(self, option: int) -> NDArray[np.float32] | None:
        """Where an option stands [3]; None if it is not drawn."""
        if 0 <= option < len(self.sizes) and self.sizes[option] > 0:
            return self.positions[option]
        return None

    def pick(self, origin: tuple[float, ...], direction: tuple[float, ...]) -> int:
        """The option that a ray from the camera meets; NO_OPTION if it meets none."""
        ray = np.array([origin, direction], np.float64)
        if ray.shape != (2, 3) or not np.isfinite(ray).all() or ray[1, 2] * ray[0, 2] >= 0:
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
    return Picture(
        layout=layout,
        positions=positions,
        colors=np.where(
            visits[:, None] > 0, colors[view.best_actions[: len(drawn)]], np.uint8(UNTRIED)
        ).astype(np.uint8),
        sizes=np.where(drawn, np.clip(0.24 + 0.045 * np.log2(1 + visits), 0, 0.46), 0).astype(
            np.float32
        ),
        edges=np.stack([positions[view.parents[children]], positions[children]], axis=1),
    )


class Gallery:
    """Pictures of the forests on screen; each is laid out once, however many browsers watch."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._pictures: dict[ForestKey, Picture] = {}
        self._drawn_from: dict[ForestKey, ForestView] = {}
        self._rest_until: dict[ForestKey, float] = {}

    def get(self, key: ForestKey, view: ForestView, spec: TaskSpec) -> Picture:
        """The picture of a forest as it is now, or a moment ago if it grows fast.

        The run's forest grows in place; a file's, and any that was tidied up, begins compact.
        """
        known, drawn_from = self._pictures.get(key), self._drawn_from.get(key)
        began = self._clock()
        if known is not None and (drawn_from is view or began < self._rest_until[key]):
            return known
        if known is not None and drawn_from is not None and drawn_from.revision == view.revision:
            layout = known.layout
        elif known is not None:
            layout = lay_out(view, known.layout)
        else:
            layout = lay_out(view, EMPTY if key[0] == "run" and key[2] == 0 else None)
        self._pictures[key], self._drawn_from[key] = draw(view, layout, spec), view
        ended = self._clock()
        self._rest_until[key] = ended + _REST * (ended - began)
        return self._pictures[key]

    def keep_only(self, keys: set[ForestKey]) -> None:
        """Forgets forests that no browser shows any more."""
        for gone in self._pictures.keys() - keys:
            for memory in (self._pictures, self._drawn_from, self._rest_until):
                memory.pop(gone, None)
