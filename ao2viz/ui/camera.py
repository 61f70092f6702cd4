"""Where the camera of one browser stands, and where on the canvas it sees a point."""

from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from ao2viz.layout.fitting import fit_window
from ao2viz.ui.look import Requests

_FOV = 0.6
_MARGIN_PX = 14.0
# What a page calls a pixel is unknown here; sharp screens have two or three for each. A picture is
# never taken for taller than this, so that words and panels are taken for too big, never too small.
_TALLEST_PX = 900.0
_TILT = np.radians(36.0)  # Above the horizon, for what has depth.
_NEAR_FOCUS = 4.0  # Kept around what the camera is to be moved to.
_ROUNDS = 5


@dataclass(frozen=True, eq=False)
class Lens:
    """One moment of a browser's camera."""

    position: NDArray[np.float64]  # [3]
    rotation: NDArray[np.float64]  # [3, 3] columns: right, down and forward in the scene.
    fov: float  # Radians, from top to bottom.
    window: tuple[float, float]  # Width and height in pixels.

    def see(self, points: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Where points [M, 3] are on the canvas, [M, 2] pixels, and how far in front [M]."""
        toward = (np.asarray(points, np.float64) - self.position) @ self.rotation
        depth = np.maximum(toward[:, 2], 1e-9)
        focal = self.window[1] / 2 / np.tan(self.fov / 2)
        return toward[:, :2] / depth[:, None] * focal + np.array(self.window) / 2, toward[:, 2]


class Eye:
    """Reads one browser's camera.

    A slow browser draws with fewer pixels than it shows. The most that it ever drew are what words
    and panels are measured against, for as long as its window keeps its shape.
    """

    def __init__(self, camera: viser.CameraHandle) -> None:
        self._camera = camera
        self._best = (0.0, 0.0)

    def look(self) -> Lens | None:
        """The camera as the browser reported it last; None while that is nothing to go by."""
        camera = self._camera
        width, height = float(camera.image_width), float(camera.image_height)
        numbers = np.array([width, height, camera.fov, *camera.position, *camera.wxyz])
        if not np.isfinite(numbers).all() or min(width, height) < 1 or not 0.01 < camera.fov < 3:
            return None  # A minimised window has no height.
        if abs(width / height * self._best[1] - self._best[0]) > 0.01 * self._best[0] + 2:
            self._best = (width, height)
        self._best = max(self._best, (width, height))
        return _lens(camera, *self._best)


def _lens(camera: viser.CameraHandle, width: float, height: float) -> Lens:
    shrink = min(1.0, _TALLEST_PX / height)
    w, x, y, z = camera.wxyz / max(float(np.linalg.norm(camera.wxyz)), 1e-9)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    window = width * shrink, height * shrink
    return Lens(np.array(camera.position), rotation, float(camera.fov), window)


@dataclass(frozen=True, eq=False)
class Sight:
    """What there is to look at."""

    outline: NDArray[np.float64]  # [K, 4] balls x, y, z, radius that hold the whole picture.
    is_flat: bool  # Seen from straight above.
    path: NDArray[np.float32]  # [P, 3]
    selection: NDArray[np.float32] | None  # [3]
    panel: tuple[float, float]  # Pixels in the lower left corner that a panel covers.


class CameraMan:
    """Moves the camera where a person asks, and keeps a growing forest in view.

    Once a person has moved the camera it is theirs until they ask again.
    """

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._done: Requests | None = None
        self._shot: _Shot | None = None

    def follow(self, sight: Sight, requests: Requests, lens: Lens | None) -> None:
        """Does what is wished for since last time."""
        if lens is None:
            return
        camera = self._client.camera
        done, self._done = self._done, requests
        known = done if done is not None else requests
        if requests.path_focuses != known.path_focuses and len(sight.path):
            self._look_at(_around(sight.path), sight.is_flat, lens, (0.0, 0.0))
        elif requests.selection_focuses != known.selection_focuses and sight.selection is not None:
            self._look_at(_around(sight.selection[None], 12), sight.is_flat, lens, (0.0, 0.0))
        elif done is None or requests.fits != done.fits or self._is_outgrown(camera, sight, lens):
            self._look_at(sight.outline, sight.is_flat, lens, sight.panel)
            box = _box(sight.outline)
            self._shot = _Shot(box, lens.window, sight.is_flat, np.array(camera.position))

    def _is_outgrown(self, camera: viser.CameraHandle, sight: Sight, lens: Lens) -> bool:
        shot = self._shot
        return shot is not None and shot.is_still(camera) and shot.misses(sight, lens)

    def _look_at(
        self,
        balls: NDArray[np.float64],
        is_flat: bool,
        lens: Lens,
        panel: tuple[float, float],
    ) -> None:
        target, back, distance = find_view(balls, is_flat, lens.window, panel)
        camera = self._client.camera
        with self._client.atomic():
            camera.fov = _FOV
            camera.near, camera.far = distance / 200, distance * 20
            camera.up_direction = (0.0, 1.0, 0.0) if is_flat else (0.0, 0.0, 1.0)
            camera.position = tuple(target + distance * back)
            camera.look_at = tuple(target)
        self._shot = None


def find_view(
    balls: NDArray[np.float64],
    is_flat: bool,
    window: tuple[float, float],
    panel: tuple[float, float],
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """What to look at [3], the direction from there to the camera [3], and how far to go.

    Everything is in the window then and nothing behind the panel, as big as can be.
    """
    tilt = np.pi / 2 if is_flat else _TILT
    right = np.array([1.0, 0.0, 0.0])
    upward = np.array([0.0, np.sin(tilt), np.cos(tilt)])
    back = np.array([0.0, -np.cos(tilt), np.sin(tilt)])
    points, radii = balls[:, :3], balls[:, 3]
    target = points.mean(axis=0)
    distance = np.inf
    # What is nearer looks bigger; how much depends on the distance that is looked for.
    for _ in range(1 if is_flat else _ROUNDS):
        offsets = points - target
        nearness = 1.0 / np.maximum(1.0 - offsets @ back / distance, 0.1)
        seen = np.column_stack([offsets @ right, offsets @ upward, radii]) * nearness[:, None]
        scale, (x, y) = fit_window(seen, window, panel, _MARGIN_PX)
        target = target + x * right + y * upward
        distance = window[1] / 2 / scale / np.tan(_FOV / 2)
    return target, back, distance


@dataclass(frozen=True, eq=False)
class _Shot:
    """What we last put in view as a whole, to tell whether a person has moved since."""

    box: NDArray[np.float64]  # [2, 3]
    window: tuple[float, float]
    is_flat: bool
    position: NDArray[np.float64]

    def is_still(self, camera: viser.CameraHandle) -> bool:
        moved = np.abs(camera.position - self.position).max()
        return bool(moved < 1e-3 * max(1.0, float(np.abs(self.position).max())))

    def misses(self, sight: Sight, lens: Lens) -> bool:
        """Whether the window has changed its shape, or the picture stands out of it or shrank."""
        aspects = lens.window[0] / lens.window[1], self.window[0] / self.window[1]
        if abs(aspects[0] - aspects[1]) > 0.01 or sight.is_flat is not self.is_flat:
            return True
        box = _box(sight.outline)
        size = float((self.box[1] - self.box[0]).max())
        outside = max(float((self.box[0] - box[0]).max()), float((box[1] - self.box[1]).max()))
        shrunk = float((box[1] - box[0]).max()) < 0.75 * size
        return outside > 0.02 * size or shrunk


def _around(points: NDArray, room: float = _NEAR_FOCUS) -> NDArray[np.float64]:
    return np.column_stack([points, np.full(len(points), room)]).astype(np.float64)


def _box(balls: NDArray[np.float64]) -> NDArray[np.float64]:
    reach = balls[:, 3:]
    return np.stack([(balls[:, :3] - reach).min(axis=0), (balls[:, :3] + reach).max(axis=0)])
