"""The pictures of all forests on screen: made once for each look, growing without a jump."""

import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.figures.coloring import Coloring, find_agreement
from ao2viz.layout.discs import Layout, has_crowded, has_regrown, lay_out
from ao2viz.layout.state_space import Axes, extend_axes, fit_axes
from ao2viz.recording.past import Past
from ao2viz.ui.look import Look
from ao2viz.ui.picture import Ground, Picture, draw
from ao2viz.ui.view import ForestKey

_ROOM = 1.7  # A forest that grows is arranged with so many times the places it needs.
_GLIDE_S = 0.9  # A forest rearranges itself in so long …
_GLIDE_LIMIT = 6_000  # … unless it is so big that sending every moment of it takes too long.
# A growing forest is laid out again only after this many times as long as the last time took, so
# that the screen stays quick however big the forest is.
_REST = 5.0
_ASIDE = _GLIDE_LIMIT
"""Forests with more options are laid out in a thread, so that nobody's screen waits for it."""

_GroundKey = tuple[ForestKey, tuple[int, ...]]  # Of a forest: () its discs, else its axes.
PictureKey = tuple[ForestKey, Look]
"""Tells pictures apart: which forest, seen how."""


@dataclass(frozen=True, eq=False)
class _Laid:
    """A ground, the forest that it was made for, and when it may be made again."""

    ground: Ground
    view: ForestView
    rest_until: float


@dataclass(frozen=True, eq=False)
class _Glide:
    """A move of all options from one layout to another."""

    start: Layout
    began: float
    ends_at: float


class Gallery:
    """Pictures of the forests on screen; each is made once, however many browsers watch.

    Options of a growing forest stay where they are. Only when it regrows as a whole, or its discs
    have run into one another, do they glide to a fresh arrangement.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._laid: dict[_GroundKey, _Laid] = {}
        self._glides: dict[ForestKey, _Glide] = {}
        self._drawn: dict[PictureKey, tuple[tuple[object, ...], Picture]] = {}
        self._agreement = _AgreementStore()
        self._thread: ThreadPoolExecutor | None = None
        self._coming: dict[_GroundKey, Future[_Laid]] = {}

    @property
    def is_busy(self) -> bool:
        """Whether a picture is about to change by itself."""
        return bool(self._glides or self._coming) or self._agreement.is_busy

    def get(
        self, key: ForestKey, view: ForestView, spec: TaskSpec, look: Look | None = None
    ) -> Picture | None:
        """The picture of a forest as it is now, or a moment ago if it is big or grows fast.

        None: it is being laid out for the first time.
        """
        look = look if look is not None else Look()
        began = self._clock()
        laid = self._laid_out(key, view, look)
        if laid is None:
            return None
        agreement = None
        if look.coloring is Coloring.AGREEMENT:
            agreement = self._agreement.get(key, laid.view)
        picture = self._draw((key, look), laid, spec, agreement)
        return picture if look.is_still else self._glide(key, picture, began)

    def get_past(
        self, key: ForestKey, past: Past, view: ForestView, spec: TaskSpec, look: Look
    ) -> Picture | None:
        """The picture of a past moment; every option stands where it stands at every moment.

        None: all that ever was is being laid out for the first time.
        """
        laid = self._laid_out(key, past.ever, look)
        if laid is None:
            return None
        known = self._drawn.get((key, look))
        if known is not None and known[0][0] is view and known[0][1] is laid:
            return known[1]
        picture = draw(view, laid.ground, spec, look, order=past.by_end)
        self._drawn[(key, look)] = ((view, laid), picture)
        return picture

    def _laid_out(self, key: ForestKey, view: ForestView, look: Look) -> _Laid | None:
        """The newest ground of a forest; None while there is none."""
        ground_key = (key, () if look.arrangement.is_of_discs else look.axes)
        coming = self._coming.get(ground_key)
        if coming is not None and coming.done():
            del self._coming[ground_key]
            self._laid[ground_key] = coming.result()
        laid = self._laid.get(ground_key)
        if laid is not None and (laid.view is view or self._clock() < laid.rest_until):
            return laid
        if len(view.parents) <= _ASIDE:
            laid = self._laid[ground_key] = self._lay_out(key, view, look, laid)
        elif ground_key not in self._coming:
            if self._thread is None:
                self._thread = ThreadPoolExecutor(1, "layout")
            work = self._thread.submit(self._lay_out, key, view, look, laid)
            self._coming[ground_key] = work
        return laid

    def _lay_out(self, key: ForestKey, view: ForestView, look: Look, laid: _Laid | None) -> _Laid:
        began = self._clock()
        ground = self._lay(key, view, look, laid)
        ended = self._clock()
        return _Laid(ground, view, ended + _REST * (ended - began))

    def _draw(
        self,
        key: PictureKey,
        laid: _Laid,
        spec: TaskSpec,
        agreement: NDArray[np.float64] | None,
    ) -> Picture:
        made_of = (laid, agreement)
        known = self._drawn.get(key)
        if known is not None and all(a is b for a, b in zip(known[0], made_of, strict=True)):
            return known[1]
        picture = draw(laid.view, laid.ground, spec, key[1], agreement)
        self._drawn[key] = (made_of, picture)
        return picture

    def _lay(self, key: ForestKey, view: ForestView, look: Look, laid: _Laid | None) -> Ground:
        if not look.arrangement.is_of_discs:
            values = view.values[view.is_alive]
            if laid is None or not isinstance(laid.ground, Axes):
                return fit_axes(values, look.axes)
            return extend_axes(laid.ground, values)
        room = _ROOM if key[0] == "run" else 1.0
        if laid is None or not isinstance(laid.ground, Layout):
            return lay_out(view, None, room)
        before = laid.ground
        if laid.view.revision == view.revision:
            return before
        if len(before.roots) == 0:
            return lay_out(view, None, room)
        if not has_regrown(laid.view, view):
            grown = lay_out(view, before)
            if len(view) > _GLIDE_LIMIT or not has_crowded(grown):
                return grown
        fresh = lay_out(view, None, room)
        if len(view) <= _GLIDE_LIMIT:
            now = self._clock()
            self._glides[key] = _Glide(before, now, now + _GLIDE_S)
        return fresh

    def _glide(self, key: ForestKey, picture: Picture, now: float) -> Picture:
        glide = self._glides.get(key)
        if glide is None or not isinstance(picture.ground, Layout):
            return picture
        if now >= glide.ends_at:
            del self._glides[key]
            return picture
        return _between(glide, picture, picture.ground, now)

    def keep_only(self, keys: Iterable[PictureKey]) -> None:
        """Forgets pictures that no browser shows any more."""
        kept = set(keys)
        forests = {key for key, _ in kept}
        self._drawn = {k: v for k, v in self._drawn.items() if k in kept}
        self._laid = {k: v for k, v in self._laid.items() if k[0] in forests}
        self._glides = {k: v for k, v in self._glides.items() if k in forests}
        for gone in [k for k in self._coming if k[0] not in forests]:
            self._coming.pop(gone).cancel()
        self._agreement.keep_only(forests)

    def close(self) -> None:
        """Ends what still works in the background."""
        if self._thread is not None:
            self._thread.shutdown(wait=True, cancel_futures=True)
        self._agreement.close()


class _AgreementStore:
    """Works out in a thread of its own whom an option's neighbours agree with.

    While a newer answer is on its way the last one stands: options keep their ids.
    """

    def __init__(self) -> None:
        self._thread: ThreadPoolExecutor | None = None
        self._known: dict[ForestKey, tuple[ForestView, NDArray[np.float64]]] = {}
        self._coming: dict[ForestKey, tuple[ForestView, Future[NDArray[np.float64]]]] = {}

    def get(self, key: ForestKey, view: ForestView) -> NDArray[np.float64] | None:
        """The newest answer that there is; None before the first."""
        coming = self._coming.get(key)
        if coming is not None and coming[1].done():
            del self._coming[key]
            self._known[key] = (coming[0], coming[1].result())
        known = self._known.get(key)
        if key not in self._coming and (known is None or known[0] is not view):
            if self._thread is None:
                self._thread = ThreadPoolExecutor(1, "agreement")
            self._coming[key] = (view, self._thread.submit(find_agreement, view))
        return known[1] if known is not None else None

    @property
    def is_busy(self) -> bool:
        """Whether an answer is on its way."""
        return bool(self._coming)

    def keep_only(self, keys: set[ForestKey]) -> None:
        """Forgets forests that nobody looks at."""
        for key in self._known.keys() - keys:
            del self._known[key]
        for key in self._coming.keys() - keys:
            self._coming.pop(key)[1].cancel()

    def close(self) -> None:
        """Waits for what is being worked out."""
        if self._thread is not None:
            self._thread.shutdown(wait=True, cancel_futures=True)


def _between(glide: _Glide, picture: Picture, ground: Layout, now: float) -> Picture:
    """The picture part of the way from an old layout to its own."""
    progress = (now - glide.began) / (glide.ends_at - glide.began)
    eased = progress * progress * (3 - 2 * progress)
    old, new = glide.start.positions, ground.positions
    both = np.flatnonzero(~np.isnan(old[: len(new), 0]) & ~np.isnan(new[: len(old), 0]))
    positions = new.copy()
    positions[both] = old[both] + (new[both] - old[both]) * eased
    layout = replace(ground, positions=positions, centres=positions[ground.roots])
    points = picture.positions.copy()
    points[both, :2] = positions[both]
    edges = np.stack([points[picture.edge_ends[:, 0]], points[picture.edge_ends[:, 1]]], axis=1)
    return replace(picture, ground=layout, positions=points, edges=edges)
