"""The options of a forest on one browser's canvas, a thousand to a node."""

from collections import deque

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


class Chunks:
    """The forest itself. However big it is, one call sends a bounded part of it."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._chunks: list[_Shapes | _Dots] = []
        self._kind: tuple[object, ...] = ()
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
        for chunk in self._chunks:
            if isinstance(chunk, _Shapes):
                chunk.edges.colors = np.array(color, np.uint8)

    def show(self, picture: Picture | None, without: tuple[int, ...]) -> None:
        """Has a picture shown by the next calls of `work`, all but the options `without`."""
        kind = () if picture is None else (picture.detail is Detail.DOTS, picture.is_flat)
        count = 0 if picture is None or kind != self._kind else -(-len(picture.drawn) // CHUNK)
        for chunk in self._chunks[count:]:
            chunk.remove()
        del self._chunks[count:]
        self._picture, self._kind = picture, kind
        if picture is None:
            self._stale.clear()
            return
        self._sizes = picture.drawn_sizes
        if without and picture.detail is Detail.ROOTS:
            self._sizes = np.where(np.isin(picture.drawn, without), 0, self._sizes)
        count = -(-len(picture.drawn) // CHUNK)
        # Those that have waited the longest come first, so that none waits for ever.
        waiting = [number for number in self._stale if number < count]
        known = set(waiting)
        self._stale = deque([*waiting, *(i for i in range(count) if i not in known)])

    def work(self) -> None:
        """Brings some chunks up to date. Viser sends no array that equals the last one."""
        picture = self._picture
        for _ in range(min(AT_A_TIME, len(self._stale)) if picture is not None else 0):
            assert picture is not None
            number = self._stale.popleft()
            while len(self._chunks) <= number:
                at = len(self._chunks)
                if picture.detail is Detail.DOTS:
                    self._chunks.append(_Dots(self._scene, at))
                else:
                    self._chunks.append(_Shapes(self._scene, at, picture.is_flat, self._edge))
            self._chunks[number].sync(picture, self._sizes)


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

    def __init__(self, scene: viser.SceneApi, number: int, is_flat: bool, edge: Rgb) -> None:
        self._rows = slice(number * CHUNK, (number + 1) * CHUNK)
        kind = "nodes" if is_flat else "balls"
        name = f"/forest/{kind}/{number:06d}"
        self._nodes = add_batch(scene, name, _mesh(is_flat), CHUNK, (0, 0, 0))
        self.edges = add_lines(scene, f"/forest/edges/{number:06d}", edge, 1.0)

    def sync(self, picture: Picture, sizes: NDArray[np.float32]) -> None:
        """Shows its part of a picture."""
        options = picture.drawn[self._rows]
        place(self._nodes, picture.positions[options], sizes[self._rows], 0.0)
        paint(self._nodes, picture.colors[options])
        draw_lines(self.edges, picture.edges[self._rows], _Z_EDGE)

    def remove(self) -> None:
        """Takes it off the canvas."""
        self._nodes.remove()
        self.edges.remove()


class _Dots:
    """Up to CHUNK options, each a dot."""

    def __init__(self, scene: viser.SceneApi, number: int) -> None:
        self._rows = slice(number * CHUNK, (number + 1) * CHUNK)
        self._dots = add_dots(scene, f"/forest/dots/{number:06d}", CHUNK)

    def sync(self, picture: Picture, sizes: NDArray[np.float32]) -> None:
        """Shows its part of a picture."""
        options = picture.drawn[self._rows]
        options = options[sizes[self._rows] > 0]
        place_dots(self._dots, picture.positions[options], picture.colors[options], _Z_DOT)

    def remove(self) -> None:
        """Takes it off the canvas."""
        self._dots.remove()


def _mesh(is_flat: bool) -> Mesh:
    return CIRCLE if is_flat else BALL
