"""Viser's scene nodes as this page uses them: batches of one shape, and segments of one colour."""

from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from ao2viz.figures.palette import Rgb
from ao2viz.ui.tones import to_albedo


@dataclass(frozen=True)
class Mesh:
    """A shape of radius 1 around the origin."""

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]


def _circle(n: int, inner: float = 0.0) -> Mesh:
    """A flat disc that faces +z, or a ring around a hole."""
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(n)])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    if inner == 0:
        middle = np.zeros((1, 3))
        faces = np.column_stack([i, j, np.full(n, n)])
        return Mesh(np.r_[rim, middle].astype(np.float32), faces.astype(np.uint32))
    faces = np.r_[np.column_stack([i, j, n + j]), np.column_stack([i, n + j, n + i])]
    return Mesh(np.r_[rim, rim * inner].astype(np.float32), faces.astype(np.uint32))


def _ball() -> Mesh:
    """An octahedron, each face divided into four: round enough for a dot, and quick to draw."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    vertices, faces = list(axes), []
    for x in (0, 3):
        for y in (1, 4):
            for z in (2, 5):
                a, b, c = (x, y, z) if (x < 3) ^ (y < 3) ^ (z < 3) else (x, z, y)
                first = len(vertices)
                for p, q in ((a, b), (b, c), (c, a)):
                    vertices.append((axes[p] + axes[q]) / np.sqrt(2))
                ab, bc, ca = first, first + 1, first + 2
                faces += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return Mesh(np.array(vertices, np.float32), np.array(faces, np.uint32))


CIRCLE, BIG_CIRCLE, RING, BALL = _circle(16), _circle(96), _circle(40, 0.78), _ball()
DIAMOND = _circle(4)

_DOT = 0.8  # Across; options are at least 1 apart.


def add_batch(
    scene: viser.SceneApi, name: str, mesh: Mesh, capacity: int, color: Rgb
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


def add_lines(
    scene: viser.SceneApi, name: str, color: Rgb, pixels: float
) -> viser.LineSegmentsHandle:
    """A node of line segments, so many pixels wide."""
    return scene.add_line_segments(
        name,
        np.zeros((1, 2, 3), np.float32),
        color,
        thickness=pixels,
        thickness_units="screen",
        visible=False,
    )


def draw_lines(handle: viser.LineSegmentsHandle, segments: NDArray, height: float) -> None:
    """Shows segments [M, 2, 3], raised by a height; nothing if there are none."""
    handle.visible = len(segments) > 0
    if len(segments):
        raised = np.array(segments, np.float32)
        raised[..., 2] += height
        handle.points = raised


def place(handle: viser.BatchedMeshHandle, points: NDArray, sizes: NDArray, height: float) -> None:
    """Puts instances at points [M, 3], raised by a height; the rest of the batch vanishes."""
    capacity = len(handle.batched_positions)
    positions, scales = np.zeros((capacity, 3), np.float32), np.zeros(capacity, np.float32)
    positions[: len(points)] = points
    positions[:, 2] += height
    scales[: len(sizes)] = sizes
    handle.batched_positions = positions
    handle.batched_scales = scales


def paint(handle: viser.BatchedMeshHandle, colors: NDArray[np.uint8]) -> None:
    """Gives the first instances these colours [M, 3], as they are to be seen."""
    padded = np.zeros((len(handle.batched_positions), 3), np.uint8)
    padded[: len(colors)] = colors
    handle.batched_colors = to_albedo(padded)


def dye(handle: viser.BatchedMeshHandle, color: Rgb) -> None:
    """Gives all instances one colour, as it is to be seen."""
    capacity = len(handle.batched_positions)
    handle.batched_colors = np.tile(to_albedo(np.array(color, np.uint8)), (capacity, 1))


def add_dots(scene: viser.SceneApi, name: str, capacity: int) -> viser.PointCloudHandle:
    """A node of so many dots of one size; none is seen yet."""
    return scene.add_point_cloud(
        name,
        np.zeros((capacity, 3), np.float32),
        np.zeros((capacity, 3), np.uint8),
        point_size=_DOT,
        point_shape="circle",
        point_shading="flat",
        precision="float32",
        visible=False,
    )


def place_dots(
    handle: viser.PointCloudHandle, points: NDArray, colors: NDArray[np.uint8], height: float
) -> None:
    """Shows dots at points [M, 3], raised by a height, in these colours [M, 3]; at most all."""
    handle.visible = len(points) > 0
    if len(points) == 0:
        return
    # Dots that are not needed hide behind the first: all that are sent together stay as many.
    rows = np.arange(len(handle.points))
    rows[len(points) :] = 0
    raised = points[rows].astype(np.float32)
    raised[:, 2] += height
    handle.points = raised
    handle.colors = colors[rows]
