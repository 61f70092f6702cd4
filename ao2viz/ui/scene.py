"""The canvas of one browser: thin code that hands arrays to viser."""

from typing import NamedTuple

import numpy as np
import viser

from ao2viz.figures.palette import EDGE, IMAGINED, PATH, SELECTED, Rgb
from ao2viz.ui.camera import CameraMan, Lens, Sight
from ao2viz.ui.lettering import Lettering
from ao2viz.ui.look import Requests
from ao2viz.ui.nodes import (
    BALL,
    BIG_CIRCLE,
    CIRCLE,
    DIAMOND,
    RING,
    add_batch,
    add_lines,
    draw_lines,
    paint,
    place,
)
from ao2viz.ui.overlay import SHARE_LEVELS, Overlay
from ao2viz.ui.picture import Picture
from ao2viz.ui.tones import LIGHT

CHUNK = 1_000
"""Options in one scene node: when the forest grows only the last chunk is sent again."""

_PATH_LIMIT = 256  # Longer paths are drawn from their end.
_VOTERS = 64
_DISCS = 64
_DISC_COLOR: Rgb = (25, 29, 38)
_AXIS: Rgb = (150, 160, 176)
# The path's pink, fading with share.
_THIN: tuple[Rgb, ...] = ((150, 52, 112), (196, 62, 142), (228, 68, 160))
_THIN_PX = (1.2, 2.0, 3.0)
_RING_GROWTH = 1.7  # A ring seen aslant has to be bigger than a halo.
# Heights above the plane: what explains lies over what is explained.
(_Z_DISC, _Z_EDGE, _Z_TRAIL, _Z_VOTE, _Z_VOTER, _Z_PATH, _Z_AHEAD, _Z_HALO, _Z_CORE, _Z_RING) = (
    np.array([-0.4, -0.2, 0.05, 0.1, 0.15, 0.2, 0.22, 0.25, 0.3, 0.35])
)


def prepare(scene: viser.SceneApi) -> None:
    """Sets up what all browsers share: flat light, so that colours mean what the legend says."""
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.add_light_ambient("/light", intensity=LIGHT)
    scene.set_up_direction("+y")
    scene.world_axes.visible = False


class Canvas:
    """The forest and the overlay in one browser. Only the app loop may call it."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._picture: Picture | None = None
        self._overlay: Overlay | None = None
        self._chunks: list[_Chunk] = []
        self._discs: viser.BatchedMeshHandle | None = None
        self._camera_man = CameraMan(client)
        scene = client.scene
        self._votes = [
            add_lines(scene, f"/path/votes/{level}", _THIN[level], _THIN_PX[level])
            for level in range(SHARE_LEVELS)
        ]
        self._path = add_lines(scene, "/path/line", PATH, 5.0)
        self._marks = {is_flat: _add_marks(scene, is_flat) for is_flat in (True, False)}
        self._ring = add_batch(scene, "/selected", RING, 1, SELECTED)
        self._schema = add_lines(scene, "/schema", EDGE, 1.5)
        self._trail = add_lines(scene, "/now/trail", SELECTED, 1.5)
        self._now = add_batch(scene, "/now/state", DIAMOND, 2, SELECTED)
        paint(self._now, np.array([SELECTED, PATH], np.uint8))
        self._ahead = add_lines(scene, "/ahead/line", IMAGINED, 3.0)
        self._ahead_end = add_batch(scene, "/ahead/end", DIAMOND, 1, IMAGINED)
        self._axes = add_lines(scene, "/axes", _AXIS, 1.5)
        self._lettering = Lettering(scene)

    def sync(self, picture: Picture | None, overlay: Overlay | None, lens: Lens | None) -> None:
        """Shows a forest and a decision. Viser sends no array that equals the last one."""
        with self._client.atomic():
            if picture is not self._picture:
                self._sync_forest(picture)
                self._picture = picture
            if overlay is not self._overlay:
                self._sync_overlay(overlay)
                self._overlay = overlay
            self._lettering.sync(self._overlay, lens)

    def aim(self, requests: Requests, panel: tuple[float, float], lens: Lens | None) -> None:
        """Moves the camera where a person asked; `panel` is covered, lower left, in pixels."""
        picture, overlay = self._picture, self._overlay
        if picture is None:
            return
        path = overlay.path if overlay is not None else np.empty((0, 3), np.float32)
        selection = overlay.selected if overlay is not None else None
        sight = Sight(picture.outline, picture.is_flat, path, selection, panel)
        self._camera_man.follow(sight, requests, lens)

    def _sync_forest(self, picture: Picture | None) -> None:
        count = 0 if picture is None else len(picture.sizes)
        n_chunks = -(-count // CHUNK)
        if picture is not None and self._chunks and self._chunks[0].is_flat != picture.is_flat:
            n_chunks = 0
        for chunk in self._chunks[n_chunks:]:
            chunk.remove()
        del self._chunks[n_chunks:]
        if picture is None:
            if self._discs is not None:
                self._discs.visible = False
            return
        while len(self._chunks) < -(-count // CHUNK):
            chunk = _Chunk(self._client.scene, len(self._chunks), is_flat=picture.is_flat)
            self._chunks.append(chunk)
        for chunk in self._chunks:
            chunk.sync(picture)
        self._sync_discs(picture)

    def _sync_discs(self, picture: Picture) -> None:
        centres, radii = picture.discs
        capacity = -(-max(len(radii), 1) // _DISCS) * _DISCS
        if self._discs is None or len(self._discs.batched_positions) != capacity:
            self._discs = add_batch(self._client.scene, "/discs", BIG_CIRCLE, capacity, _DISC_COLOR)
        self._discs.visible = len(radii) > 0
        place(self._discs, np.pad(centres, ((0, 0), (0, 1))), radii, _Z_DISC)

    def _sync_overlay(self, overlay: Overlay | None) -> None:
        is_flat = self._picture is None or self._picture.is_flat
        nothing = np.empty((0, 2, 3), np.float32)
        for level, handle in enumerate(self._votes):
            draw_lines(handle, nothing if overlay is None else overlay.votes[level], _Z_VOTE)
        for kind, marks in self._marks.items():
            marks.sync(overlay if kind is is_flat else None)
        points = nothing[:, 0] if overlay is None else overlay.path[-_PATH_LIMIT:]
        draw_lines(self._path, np.stack([points[:-1], points[1:]], axis=1), _Z_PATH)
        for handle, lines, height in (
            (self._schema, None if overlay is None else overlay.schema, _Z_EDGE),
            (self._trail, None if overlay is None else overlay.trail, _Z_TRAIL),
            (self._axes, None if overlay is None else overlay.axes, _Z_EDGE),
            (self._ahead, None if overlay is None else overlay.ahead, _Z_AHEAD),
        ):
            draw_lines(handle, nothing if lines is None else lines, height)
        end = None if overlay is None else overlay.ahead_end
        self._ahead_end.visible = end is not None
        if end is not None:
            place(self._ahead_end, end[None], np.array([1.1]), _Z_RING)
        selected = None if overlay is None else overlay.selected
        self._ring.visible = selected is not None
        if selected is not None:
            place(self._ring, selected[None], np.array([1.0]), _Z_RING)
        now = None if overlay is None else overlay.now
        self._now.visible = now is not None
        if now is not None:
            inner = now + np.array([0, 0, 0.05], np.float32)
            place(self._now, np.stack([now, inner]), np.array([1.5, 1.1]), _Z_RING)


class _Marks(NamedTuple):
    """The options that the decision rests on; one set lies flat, one is round."""

    voters: viser.BatchedMeshHandle
    halos: viser.BatchedMeshHandle
    cores: viser.BatchedMeshHandle
    is_flat: bool

    def sync(self, overlay: Overlay | None) -> None:
        """Shows the path and the voters; None shows nothing."""
        for handle in (self.voters, self.halos, self.cores):
            handle.visible = overlay is not None
        if overlay is None:
            return
        sizes = overlay.path_sizes[-_PATH_LIMIT:]
        halo = np.maximum(sizes + 0.3, 0.62) * (1.0 if self.is_flat else _RING_GROWTH)
        if len(halo):
            halo[-1] += 0.18  # The option that decided stands out.
        points = overlay.path[-_PATH_LIMIT:]
        place(self.halos, points, halo, _Z_HALO)
        place(self.cores, points, np.maximum(sizes, 0.36), _Z_CORE)
        paint(self.cores, overlay.path_colors[-_PATH_LIMIT:])
        place(self.voters, overlay.voters[:_VOTERS], overlay.voter_sizes[:_VOTERS], _Z_VOTER)


def _add_marks(scene: viser.SceneApi, is_flat: bool) -> _Marks:
    # Around a ball a halo would hide it, so there it is a ring.
    dot, halo, name = (CIRCLE, CIRCLE, "flat") if is_flat else (BALL, RING, "deep")
    return _Marks(
        add_batch(scene, f"/path/{name}/voters", dot, _VOTERS, _THIN[1]),
        add_batch(scene, f"/path/{name}/halos", halo, _PATH_LIMIT, PATH),
        add_batch(scene, f"/path/{name}/cores", dot, _PATH_LIMIT, (0, 0, 0)),
        is_flat,
    )


class _Chunk:
    """Up to CHUNK options and the edges that lead to them."""

    def __init__(self, scene: viser.SceneApi, number: int, *, is_flat: bool) -> None:
        self.is_flat = is_flat
        self._rows = slice(number * CHUNK, (number + 1) * CHUNK)
        mesh, kind = (CIRCLE, "nodes") if is_flat else (BALL, "balls")
        self._nodes = add_batch(scene, f"/forest/{kind}/{number:06d}", mesh, CHUNK, (0, 0, 0))
        self._edges = add_lines(scene, f"/forest/edges/{number:06d}", EDGE, 1.0)

    def sync(self, picture: Picture) -> None:
        """Shows its part of a picture."""
        rows = self._rows
        place(self._nodes, picture.positions[rows], picture.sizes[rows], 0.0)
        paint(self._nodes, picture.colors[rows])
        draw_lines(self._edges, picture.edges[rows], _Z_EDGE)

    def remove(self) -> None:
        """Takes it off the canvas."""
        self._nodes.remove()
        self._edges.remove()
