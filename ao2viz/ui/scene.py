"""The canvas of one browser: thin code that hands arrays to viser."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import viser
from numpy.typing import NDArray

from ao2viz.figures.palette import EDGE, PATH, SELECTED
from ao2viz.ui.overlay import SHARE_LEVELS, Overlay
from ao2viz.ui.picture import Picture
from ao2viz.ui.tones import LIGHT, to_albedo

CHUNK = 1_000
"""Options in one scene node: when the forest grows only the last chunk is sent again."""

_PATH_LIMIT = 256  # Longer paths are drawn from their end.
_VOTERS = 64
_DISCS = 64
_FOV = 0.6
_DISC_COLOR = (25, 29, 38)
_THIN = ((150, 52, 112), (196, 62, 142), (228, 68, 160))  # The path's pink, fading with share.
_THIN_PX = (1.2, 2.0, 3.0)
# Heights above the plane: what explains lies over what is explained.
_Z_DISC, _Z_EDGE, _Z_VOTE, _Z_VOTER, _Z_PATH, _Z_HALO, _Z_CORE, _Z_RING = np.array(
    [-0.4, -0.2, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35]
)


# A label's corner that sticks to its option, by (is_left, is_above).
_ANCHORS: dict[
    tuple[bool, bool], Literal["bottom-right", "top-right", "bottom-left", "top-left"]
] = {
    (True, True): "bottom-right",
    (True, False): "top-right",
    (False, True): "bottom-left",
    (False, False): "top-left",
}


@dataclass(frozen=True)
class _Mesh:
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]


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
        self._camera: _Camera | None = None
        self._requests = (-1, -1)
        scene = client.scene
        self._votes = [
            _lines(scene, f"/path/votes/{level}", _THIN[level], _THIN_PX[level])
            for level in range(SHARE_LEVELS)
        ]
        self._voters = _batch(scene, "/path/voters", _CIRCLE, _VOTERS, _THIN[1])
        self._path = _lines(scene, "/path/line", PATH, 5.0)
        self._halos = _batch(scene, "/path/halos", _CIRCLE, _PATH_LIMIT, PATH)
        self._cores = _batch(scene, "/path/cores", _CIRCLE, _PATH_LIMIT, (0, 0, 0))
        self._ring = _batch(scene, "/selected", _RING, 1, SELECTED)
        self._labels = [
            scene.add_label(f"/labels/{i}", "", visible=False, font_screen_scale=0.85)
            for i in range(2)
        ]

    def sync(self, picture: Picture | None, overlay: Overlay | None) -> None:
        """Shows a forest and a decision. Viser sends no array that equals the last one."""
        with self._client.atomic():
            if picture is not self._picture:
                self._sync_forest(picture)
                self._picture = picture
            if overlay is not self._overlay:
                self._sync_overlay(overlay)
                self._overlay = overlay

    def aim(self, fits: int, focuses: int) -> None:
        """Moves the camera where a person asked, and keeps a growing forest in view.

        Once a person has moved the camera it is theirs until they ask again.
        """
        camera = self._client.camera
        try:
            aspect = float(camera.aspect)
        except ZeroDivisionError:  # A minimised window has no height.
            return
        if not np.isfinite(aspect) or aspect <= 0 or self._picture is None:
            return
        wanted = self._requests
        self._requests = (fits, focuses)
        overlay = self._overlay
        if focuses != wanted[1] and wanted[1] >= 0 and overlay is not None and len(overlay.path):
            low, high = overlay.path[:, :2].min(axis=0), overlay.path[:, :2].max(axis=0)
            self._look_at(low[0] - 4, high[0] + 4, low[1] - 4, high[1] + 4, aspect)
            return
        ours = self._camera if self._camera and self._camera.is_still(camera) else None
        if fits != wanted[0] or (ours and ours.misses(self._picture.box, aspect)):
            self._look_at(*self._picture.box, aspect)

    def _look_at(self, left: float, right: float, bottom: float, top: float, aspect: float) -> None:
        half_height = max((top - bottom) / 2, (right - left) / 2 / aspect, 3.0) * 1.06
        # What there is too much of the window goes below and to the left: the legend is there.
        spare_x = half_height * aspect - (right - left) / 2 * 1.06
        spare_y = half_height - (top - bottom) / 2 * 1.06
        middle = ((left + right) / 2 - spare_x, (bottom + top) / 2 - spare_y)
        height = half_height / np.tan(_FOV / 2)
        camera = self._client.camera
        with self._client.atomic():
            camera.fov = _FOV
            camera.near, camera.far = height / 200, height * 20
            camera.up_direction = (0.0, 1.0, 0.0)
            camera.position = (*middle, height)
            camera.look_at = (*middle, 0.0)
        self._camera = _Camera((left, right, bottom, top), aspect, np.array([*middle, height]))

    def _sync_forest(self, picture: Picture | None) -> None:
        count = 0 if picture is None else len(picture.sizes)
        n_chunks = -(-count // CHUNK)
        for chunk in self._chunks[n_chunks:]:
            chunk.remove()
        del self._chunks[n_chunks:]
        if picture is None:
            if self._discs is not None:
                self._discs.visible = False
            return
        while len(self._chunks) < n_chunks:
            self._chunks.append(_Chunk(self._client.scene, len(self._chunks)))
        for chunk in self._chunks:
            chunk.sync(picture)
        self._sync_discs(picture)

    def _sync_discs(self, picture: Picture) -> None:
        centres, radii = picture.layout.centres, picture.layout.radii
        capacity = -(-max(len(radii), 1) // _DISCS) * _DISCS
        if self._discs is None or len(self._discs.batched_positions) != capacity:
            self._discs = _batch(self._client.scene, "/discs", _BIG_CIRCLE, capacity, _DISC_COLOR)
        positions, sizes = _padded(np.pad(centres, ((0, 0), (0, 1))), radii, capacity, _Z_DISC)
        self._discs.visible = True
        self._discs.batched_positions = positions
        self._discs.batched_scales = sizes

    def _sync_overlay(self, overlay: Overlay | None) -> None:
        lines = overlay.path[-_PATH_LIMIT:] if overlay is not None else np.empty((0, 3), np.float32)
        _draw_lines(self._path, np.stack([lines[:-1], lines[1:]], axis=1), _Z_PATH)
        for level, handle in enumerate(self._votes):
            votes = overlay.votes[level] if overlay is not None else np.empty((0, 2, 3))
            _draw_lines(handle, votes, _Z_VOTE)
        points = lines
        sizes = (
            overlay.path_sizes[-_PATH_LIMIT:] if overlay is not None else np.empty(0, np.float32)
        )
        halo = np.maximum(sizes + 0.3, 0.62)
        if len(halo):
            halo[-1] += 0.18  # The option that decided stands out.
        _place(self._halos, points, halo, _Z_HALO)
        _place(self._cores, points, np.maximum(sizes, 0.36), _Z_CORE)
        if overlay is None:
            _place(self._voters, points[:0], sizes[:0], _Z_VOTER)
            self._ring.visible = False
        else:
            colors = np.zeros((_PATH_LIMIT, 3), np.uint8)
            colors[: len(points)] = overlay.path_colors[-_PATH_LIMIT:]
            self._cores.batched_colors = to_albedo(colors)
            _place(self._voters, overlay.voters[:_VOTERS], overlay.voter_sizes[:_VOTERS], _Z_VOTER)
            self._ring.visible = overlay.selected is not None
            if overlay.selected is not None:
                _place(self._ring, overlay.selected[None], np.array([1.0]), _Z_RING)
        self._sync_labels(overlay)

    def _sync_labels(self, overlay: Overlay | None) -> None:
        labels = overlay.labels if overlay is not None else ()
        for i, handle in enumerate(self._labels):
            handle.visible = i < len(labels)
            if handle.visible:
                label = labels[i]
                handle.text = f"{label.text}  " if label.is_left else f"  {label.text}"
                handle.anchor = _ANCHORS[label.is_left, label.is_above]
                handle.position = label.position


class _Chunk:
    """Up to CHUNK options and the edges that lead to them."""

    def __init__(self, scene: viser.SceneApi, number: int) -> None:
        self._rows = slice(number * CHUNK, (number + 1) * CHUNK)
        self._nodes = _batch(scene, f"/forest/nodes/{number:06d}", _CIRCLE, CHUNK, (0, 0, 0))
        self._edges = _lines(scene, f"/forest/edges/{number:06d}", EDGE, 1.0)

    def sync(self, picture: Picture) -> None:
        positions, sizes = _padded(
            picture.positions[self._rows], picture.sizes[self._rows], CHUNK, 0.0
        )
        colors = np.zeros((CHUNK, 3), np.uint8)
        colors[: len(picture.colors[self._rows])] = picture.colors[self._rows]
        self._nodes.batched_positions = positions
        self._nodes.batched_scales = sizes
        self._nodes.batched_colors = to_albedo(colors)
        _draw_lines(self._edges, picture.edges[self._rows], _Z_EDGE)

    def remove(self) -> None:
        self._nodes.remove()
        self._edges.remove()


@dataclass(frozen=True, eq=False)
class _Camera:
    """Where we put the camera, to tell whether a person has moved it since."""

    box: tuple[float, float, float, float]
    aspect: float
    position: NDArray[np.float64]

    def is_still(self, camera: viser.CameraHandle) -> bool:
        moved = np.abs(camera.position - self.position).max()
        return bool(moved < 1e-3 * self.position[2])

    def misses(self, box: tuple[float, float, float, float], aspect: float) -> bool:
        """Whether the window has changed its shape, or the forest stands out of it or shrank."""
        if abs(aspect - self.aspect) > 0.01:
            return True
        size = max(self.box[1] - self.box[0], self.box[3] - self.box[2])
        grown = np.subtract(box, self.box) * (-1, 1, -1, 1) / size  # Above 0: beyond that side.
        return bool(grown.max() > 0.02 or grown.min() < -0.2)


def _circle(n: int, inner: float = 0.0) -> _Mesh:
    """A flat disc of radius 1 that faces +z, or a ring around a hole."""
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(n)])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    faces = np.r_[np.column_stack([i, j, n + j]), np.column_stack([i, n + j, n + i])]
    return _Mesh(np.r_[rim, rim * inner].astype(np.float32), faces.astype(np.uint32))


_CIRCLE, _BIG_CIRCLE, _RING = _circle(18), _circle(96), _circle(40, 0.78)


def _batch(
    scene: viser.SceneApi, name: str, mesh: _Mesh, capacity: int, color: tuple[int, int, int]
) -> viser.BatchedMeshHandle:
    """A node with room for so many instances; the unused ones have no size."""
    return scene.add_batched_meshes_simple(
        name,
        mesh.vertices,
        mesh.faces,
        np.tile(np.array([1, 0, 0, 0], np.float32), (capacity, 1)),
        np.zeros((capacity, 3), np.float32),
        batched_scales=np.zeros(capacity, np.float32),
        batched_colors=np.tile(to_albedo(np.array(color, np.uint8)), (capacity, 1)),
        lod="off",
        side="double",
        flat_shading=True,
        cast_shadow=False,
        receive_shadow=False,
    )


def _lines(
    scene: viser.SceneApi, name: str, color: tuple[int, int, int], pixels: float
) -> viser.LineSegmentsHandle:
    return scene.add_line_segments(
        name,
        np.zeros((1, 2, 3), np.float32),
        color,
        thickness=pixels,
        thickness_units="screen",
        visible=False,
    )


def _draw_lines(handle: viser.LineSegmentsHandle, segments: NDArray, height: float) -> None:
    handle.visible = len(segments) > 0
    if len(segments):
        raised = np.array(segments, np.float32)
        raised[..., 2] = height
        handle.points = raised


def _padded(
    points: NDArray, sizes: NDArray, capacity: int, height: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    positions, scales = np.zeros((capacity, 3), np.float32), np.zeros(capacity, np.float32)
    positions[: len(points)] = points
    positions[:, 2] = height
    scales[: len(sizes)] = sizes
    return positions, scales


def _place(handle: viser.BatchedMeshHandle, points: NDArray, sizes: NDArray, height: float) -> None:
    positions, scales = _padded(points, sizes, len(handle.batched_positions), height)
    handle.batched_positions = positions
    handle.batched_scales = scales
