"""The canvas of one browser: thin code that hands arrays to viser."""

import numpy as np
import viser

from ao2viz.figures.palette import DARK, Palette, Rgb
from ao2viz.ui.camera import CameraMan, Lens, Sight
from ao2viz.ui.chunks import Chunks, CloseUpNodes
from ao2viz.ui.close_up import CloseUp
from ao2viz.ui.lettering import Lettering
from ao2viz.ui.look import Requests
from ao2viz.ui.nodes import (
    BALL,
    BIG_CIRCLE,
    CIRCLE,
    DIAMOND,
    RING,
    Mesh,
    add_batch,
    add_lines,
    draw_lines,
    dye,
    paint,
    place,
)
from ao2viz.ui.overlay import AHEAD_LEVELS, SHARE_LEVELS, Overlay
from ao2viz.ui.picture import Picture
from ao2viz.ui.tones import LIGHT

_PATH_LIMIT = 1_024  # Longer paths are drawn from their end.
_PATH_ROOM = 32  # For most paths; the nodes of longer ones get more, as all of it is sent anew.
_VOTERS = 64
_DISCS = 64
_THIN_PX = (1.2, 2.0, 3.0)
_AHEAD_PX = (3.0, 1.8, 1.0)
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
        self._close_up: CloseUp | None = None
        self._discs: viser.BatchedMeshHandle | None = None
        self._camera_man = CameraMan(client)
        self._palette = DARK
        scene, colors = client.scene, DARK
        self._chunks = Chunks(scene)
        self._close_up_nodes = CloseUpNodes(scene)
        self._votes = [
            add_lines(scene, f"/path/votes/{level}", colors.votes[level], _THIN_PX[level])
            for level in range(SHARE_LEVELS)
        ]
        self._path = add_lines(scene, "/path/line", colors.path, 5.0)
        self._marks = {is_flat: _Marks(scene, is_flat, colors) for is_flat in (True, False)}
        self._ring = add_batch(scene, "/selected", RING, 1, colors.selected)
        self._schema = add_lines(scene, "/schema", colors.edge, 1.5)
        self._trail = add_lines(scene, "/now/trail", colors.selected, 1.5)
        self._now = add_batch(scene, "/now/state", DIAMOND, 2, colors.selected)
        paint(self._now, np.array([colors.selected, colors.path], np.uint8))
        self._ahead = [
            add_lines(scene, f"/ahead/line/{level}", colors.imagined, _AHEAD_PX[level])
            for level in range(AHEAD_LEVELS)
        ]
        self._ahead_end = add_batch(scene, "/ahead/end", DIAMOND, 1, colors.imagined)
        self._axes = add_lines(scene, "/axes", colors.axis, 1.5)
        self._lettering = Lettering(scene)
        self._sync_overlay(None)

    def set_palette(self, colors: Palette) -> None:
        """Gives everything but the options its colour; those have theirs from the picture."""
        self._palette = colors
        with self._client.atomic():
            for lines, color in (
                *zip(self._votes, colors.votes, strict=True),
                (self._path, colors.path),
                (self._schema, colors.edge),
                (self._trail, colors.selected),
                *((lines, colors.imagined) for lines in self._ahead),
                (self._axes, colors.axis),
            ):
                lines.colors = np.array(color, np.uint8)
            self._chunks.set_edge(colors.edge)
            self._close_up_nodes.set_edge(colors.edge)
            for marks in self._marks.values():
                marks.set_palette(colors)
            dye(self._ring, colors.selected)
            dye(self._ahead_end, colors.imagined)
            paint(self._now, np.array([colors.selected, colors.path], np.uint8))
            if self._discs is not None:
                dye(self._discs, colors.disc)

    @property
    def is_busy(self) -> bool:
        """Whether some of what is shown is still to be sent."""
        return self._chunks.is_busy

    def sync(
        self,
        picture: Picture | None,
        overlay: Overlay | None,
        lens: Lens | None,
        close_up: CloseUp | None = None,
    ) -> None:
        """Shows a forest and a decision. Viser sends no array that equals the last one."""
        with self._client.atomic():
            if picture is not self._picture or close_up is not self._close_up:
                self._chunks.show(picture, close_up.roots if close_up is not None else ())
                self._close_up_nodes.sync(close_up, picture)
                self._close_up = close_up
            if picture is not self._picture:
                self._sync_discs(picture)
                self._picture = picture
            self._chunks.work()
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

    def _sync_discs(self, picture: Picture | None) -> None:
        if picture is None:
            if self._discs is not None:
                self._discs.visible = False
            return
        centres, radii = picture.discs
        capacity = -(-max(len(radii), 1) // _DISCS) * _DISCS
        if self._discs is None or len(self._discs.batched_positions) != capacity:
            self._discs = add_batch(
                self._client.scene, "/discs", BIG_CIRCLE, capacity, self._palette.disc
            )
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
        ):
            draw_lines(handle, nothing if lines is None else lines, height)
        for level, handle in enumerate(self._ahead):
            draw_lines(handle, nothing if overlay is None else overlay.ahead[level], _Z_AHEAD)
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


class _Marks:
    """The options that the decision rests on; one set lies flat, one is round."""

    def __init__(self, scene: viser.SceneApi, is_flat: bool, colors: Palette) -> None:
        self._scene, self._is_flat, self._colors = scene, is_flat, colors
        # Around a ball a halo would hide it, so there it is a ring.
        self._dot, self._halo = (CIRCLE, CIRCLE) if is_flat else (BALL, RING)
        self._name = "flat" if is_flat else "deep"
        self._voters = self._add("voters", self._dot, _VOTERS, colors.votes[1])
        self._make_room(_PATH_ROOM)

    def set_palette(self, colors: Palette) -> None:
        """Gives everything but the options its colour."""
        self._colors = colors
        dye(self._voters, colors.votes[1])
        dye(self._halos, colors.path)

    def sync(self, overlay: Overlay | None) -> None:
        """Shows the path and the voters; None shows nothing."""
        points = None if overlay is None else overlay.path[-_PATH_LIMIT:]
        if points is not None and len(points) > len(self._halos.batched_positions):
            self._make_room(len(points))
        for handle in (self._voters, self._halos, self._cores):
            handle.visible = overlay is not None
        if overlay is None or points is None:
            return
        sizes = overlay.path_sizes[-_PATH_LIMIT:]
        halo = np.maximum(sizes + 0.3, 0.62) * (1.0 if self._is_flat else _RING_GROWTH)
        if len(halo):
            halo[-1] += 0.18  # The option that decided stands out.
        place(self._halos, points, halo, _Z_HALO)
        place(self._cores, points, np.maximum(sizes, 0.36), _Z_CORE)
        paint(self._cores, overlay.path_colors[-_PATH_LIMIT:])
        place(self._voters, overlay.voters[:_VOTERS], overlay.voter_sizes[:_VOTERS], _Z_VOTER)

    def _make_room(self, least: int) -> None:
        room = _PATH_ROOM
        while room < least:
            room *= 2
        self._halos = self._add("halos", self._halo, room, self._colors.path)
        self._cores = self._add("cores", self._dot, room, (0, 0, 0))

    def _add(self, what: str, mesh: Mesh, room: int, color: Rgb) -> viser.BatchedMeshHandle:
        return add_batch(self._scene, f"/path/{self._name}/{what}", mesh, room, color)
