"""The options of a forest on one browser's canvas, a thousand to a node."""

from collections import deque
from enum import Enum
from itertools import chain

import numpy as np
import viser
from numpy.typing import NDArray

from ao2viz.figures.palette import DARK, Rgb
from ao2viz.ui.close_up import CloseUp
from ao2viz.ui.detail import Detail
from ao2viz.ui.nodes import (
    BALL,
    CIRCLE,
    Mesh,
    add_batch,
    add_dots,
    add_lines,
    draw_lines,
    paint,
    place,
    place_dots,
)
from ao2viz.ui.picture import Picture

CHUNK = 1_000
"""Options in one scene node: when the forest grows only the last chunk is sent again."""
AT_A_TIME = 32
"""Chunks that are brought up to date with one call; what changes everywhere comes bit by bit."""

_FEWEST = 1_024  # Room in the nodes of a close-up, doubled until it is enough.
_Z_EDGE, _Z_DOT = -0.2, -0.05


class _Kind(Enum):
    """What options are drawn as; nodes are named after it."""

    DOTS = "dots"
    CIRCLES = "nodes"
    BALLS = "balls"


class Chunks:
    """The forest itself. However big it is, one call sends a bounded part of it."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._chunks: dict[_Kind, dict[int, _Shapes | _Dots]] = {}  # One kind is shown.
        self._picture: Picture | None = None
        self._sizes = np.empty(0, np.float32)
        self._stale: deque[int] = deque()
        self._edge = DARK.edge

    @property
    def is_busy(self) -> bool:
        """Whether some of the picture is still to be sent."""
        return bool(self._stale)

    def set_edge(self, color: Rgb) -> None:
        """Gives all lines a colour."""
        self._edge = color
        for chunk in chain.from_iterable(chunks.values() for chunks in self._chunks.values()):
            if isinstance(chunk, _Shapes):
                chunk.edges.colors = np.array(color, np.uint8)

    def show(self, picture: Picture | None, without: tuple[int, ...]) -> None:
        """Has a picture shown by the next calls of `work`, all but the options `without`."""
        before, self._picture = self._picture, picture
        self._clear(before, picture)
        if picture is None or before is None or _kind_of(before) is not _kind_of(picture):
            self._stale.clear()
        if picture is None:
            return
        self._sizes = picture.drawn_sizes
        if without and picture.detail is Detail.ROOTS:
            self._sizes = np.where(np.isin(picture.drawn, without), 0, self._sizes)
        # Those that have waited the longest come first, so that none waits for ever.
        waiting = [number for number in self._stale if number * CHUNK < len(picture.drawn)]
        known = set(waiting)
        self._stale = deque([*waiting, *(i for i in _changes(before, picture) if i not in known)])

    def work(self) -> None:
        """Brings some chunks up to date. Viser sends no array that equals the last one."""
        picture = self._picture
        if picture is None:
            return
        kind = _kind_of(picture)
        chunks = self._chunks.setdefault(kind, {})
        for _ in range(min(AT_A_TIME, len(self._stale))):
            number = self._stale.popleft()
            if number not in chunks:
                is_dots = kind is _Kind.DOTS
                chunks[number] = (
                    _Dots(self._scene, number)
                    if is_dots
                    else _Shapes(self._scene, number, kind, self._edge)
                )
            chunks[number].sync(picture, self._sizes)

    def _clear(self, before: Picture | None, picture: Picture | None) -> None:
        """Takes away what a picture does not need: other kinds, and chunks at the end."""
        is_elsewhere = before is None or picture is None or picture.ground is not before.ground
        for kind, chunks in list(self._chunks.items()):
            is_shown = picture is not None and kind is _kind_of(picture)
            if not is_shown and not is_elsewhere:
                # A past goes to and fro between dots and shapes, and its options never move.
                for chunk in chunks.values():
                    chunk.hide()
                continue
            count = len(picture.drawn) if picture is not None and is_shown else 0
            for number in [i for i in chunks if i * CHUNK >= count]:
                chunks.pop(number).remove()


class CloseUpNodes:
    """The active schemas, drawn in full over a forest that is not."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._nodes: dict[bool, viser.BatchedMeshHandle] = {}  # By whether all lies flat.
        self._edges = add_lines(scene, "/close/edges", DARK.edge, 1.0)

    def set_edge(self, color: Rgb) -> None:
        """Gives the lines a colour."""
        self._edges.colors = np.array(color, np.uint8)

    def sync(self, close_up: CloseUp | None, picture: Picture | None) -> None:
        """Shows the options of a close-up; None shows nothing."""
        for node in self._nodes.values():
            node.visible = False
        self._edges.visible = False
        if close_up is None or picture is None:
            return
        options, flat = close_up.options, picture.is_flat
        node = self._nodes.get(flat)
        if node is None or len(node.batched_positions) < len(options):
            room = _FEWEST
            while room < len(options):
                room *= 2
            name = f"/close/{'nodes' if flat else 'balls'}"
            node = self._nodes[flat] = add_batch(self._scene, name, _mesh(flat), room, (0, 0, 0))
        node.visible = True
        place(node, picture.positions[options], picture.sizes[options], 0.0)
        paint(node, picture.colors[options])
        draw_lines(self._edges, close_up.edges, _Z_EDGE)


class _Shapes:
    """Up to CHUNK options, each in its size, and as many edges."""

    def __init__(self, scene: viser.SceneApi, number: int, kind: _Kind, edge: Rgb) -> None:
        self._rows = slice(number * CHUNK, (number + 1) * CHUNK)
        mesh = _mesh(kind is _Kind.CIRCLES)
        self._nodes = add_batch(scene, f"/forest/{kind.value}/{number:06d}", mesh, CHUNK, (0, 0, 0))
        name = f"/forest/edges of {kind.value}/{number:06d}"
        self.edges = add_lines(scene, name, edge, 1.0)

    def sync(self, picture: Picture, sizes: NDArray[np.float32]) -> None:
        """Shows its part of a picture."""
        options = picture.drawn[self._rows]
        self._nodes.visible = True
        place(self._nodes, picture.positions[options], sizes[self._rows], 0.0)
        paint(self._nodes, picture.colors[options])
        draw_lines(self.edges, picture.edges[self._rows], _Z_EDGE)

    def hide(self) -> None:
        """Shows nothing until the next `sync`."""
        self._nodes.visible = self.edges.visible = False

    def remove(self) -> None:
        """Takes it off the canvas."""
        self._nodes.remove()
        self.edges.remove()


class _Dots:
    """Up to CHUNK options, each a dot."""

    def __init__(self, scene: viser.SceneApi, number: int) -> None:
        self._rows = slice(number * CHUNK, (number + 1) * CHUNK)
        name = f"/forest/{_Kind.DOTS.value}/{number:06d}"
        self._dots = add_dots(scene, name, CHUNK)

    def sync(self, picture: Picture, sizes: NDArray[np.float32]) -> None:
        """Shows its part of a picture."""
        options = picture.drawn[self._rows]
        options = options[sizes[self._rows] > 0]
        place_dots(self._dots, picture.positions[options], picture.colors[options], _Z_DOT)

    def hide(self) -> None:
        """Shows nothing until the next `sync`."""
        self._dots.visible = False

    def remove(self) -> None:
        """Takes it off the canvas."""
        self._dots.remove()


def _kind_of(picture: Picture) -> _Kind:
    if picture.detail is Detail.DOTS:
        return _Kind.DOTS
    return _Kind.CIRCLES if picture.is_flat else _Kind.BALLS


def _changes(before: Picture | None, now: Picture) -> list[int]:
    """The chunks that may look different from one picture to another."""
    filled = _filled(now)
    if before is None or _kind_of(before) is not _kind_of(now):
        return sorted(filled)
    if now.detail is not Detail.DOTS:
        return sorted(filled | _filled(before))  # They are few, and change in more ways.
    n = min(len(before.drawn), len(now.drawn))
    then, new = before.drawn[:n], now.drawn[:n]
    differs = np.ones(max(len(before.drawn), len(now.drawn)), np.bool_)
    differs[:n] = (before.drawn_sizes[:n] > 0) != (now.drawn_sizes[:n] > 0)
    differs[:n] |= (before.positions[then] != now.positions[new]).any(axis=1)
    differs[:n] |= (before.colors[then] != now.colors[new]).any(axis=1)
    numbers = np.unique(np.flatnonzero(differs) // CHUNK)
    return numbers[numbers * CHUNK < len(now.drawn)].tolist()


def _filled(picture: Picture) -> set[int]:
    """The chunks that have something to show."""
    with_edges = range(-(-len(picture.edges) // CHUNK))
    return {*with_edges, *np.unique(np.flatnonzero(picture.drawn_sizes > 0) // CHUNK).tolist()}


def _mesh(is_flat: bool) -> Mesh:
    return CIRCLE if is_flat else BALL
