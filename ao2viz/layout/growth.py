"""Room for new options in a picture whose old options must not move."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.layout.radial import SPACING, band_gap

_CELL = 0.7 * SPACING  # Narrow enough that no two options share a cell.
_SLOT = 1.04 * SPACING  # Between neighbouring slots of a schema's rings, and between the rings.
_TERRITORY = 9.0  # Radius that a schema may claim before it has any children.
_ELBOW_ROOM = 6.0  # Kept free around the root of a new schema.
_GOLDEN_ANGLE = 2.399963229728653


class Field:
    """Which spots of the plane are taken; a grid of cells, each holding one option at most."""

    def __init__(self, extent: float) -> None:
        self.extent = extent
        self._origin = -extent
        self._size = int(np.ceil(2 * extent / _CELL)) + 1
        self._points = np.full((self._size * self._size, 2), np.inf)
        around = np.arange(-2, 3)
        self._around = (around[:, None] * self._size + around).ravel()

    def put(self, points: NDArray[np.float64]) -> None:
        """Takes the spots at these points [K, 2]."""
        cells = np.floor((points - self._origin) / _CELL).astype(np.int64)
        self._points[cells[:, 0] * self._size + cells[:, 1]] = points

    def is_free(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """[K] whether nothing stands closer than SPACING; beyond the field nothing is free."""
        cells = np.floor((points - self._origin) / _CELL).astype(np.int64)
        free: NDArray[np.bool_] = np.all((cells >= 2) & (cells < self._size - 2), axis=1)
        cells = cells[:, 0] * self._size + cells[:, 1]
        # Most spots that are taken have an option in their very cell, which is quick to see.
        free[free] = np.isinf(self._points[cells[free], 0])
        near = cells[free][:, None] + self._around
        x, y = self._points[near, 0], self._points[near, 1]
        points = points[free][:, :, None]
        free[free] = ((x - points[:, 0]) ** 2 + (y - points[:, 1]) ** 2 >= SPACING**2).all(axis=1)
        return free


def place_root(
    centres: NDArray[np.float64], reaches: NDArray[np.float64], field: Field
) -> NDArray[np.float64] | None:
    """The free spot [2] closest to the origin for a new schema; None if the field is full.

    Args:
        centres: Where the other schemas' roots stand, [S, 2].
        reaches: How far each of them stretches, [S].
        field: The spots that are taken.
    """
    step = 2.0
    # A sunflower of candidates: even in all directions, sorted by distance from the origin.
    turn = np.arange(int(np.pi * (field.extent / step) ** 2) + 1)
    radius = step * np.sqrt(turn / np.pi)
    spots = radius[:, None] * _direction(turn * _GOLDEN_ANGLE)
    claimed = np.maximum(reaches, _TERRITORY) + _ELBOW_ROOM
    for first in range(0, len(spots), 4096):
        some = spots[first : first + 4096]
        gaps = np.hypot(*(some[:, None] - centres[None]).transpose(2, 0, 1))
        fits = (gaps >= claimed).all(axis=1) & field.is_free(some)
        if fits.any():
            return some[np.argmax(fits)]
    return None


class Rings:
    """The free spots of one schema: slots on rings around its root."""

    def __init__(self, centre: NDArray[np.float64], reach: float, field: Field) -> None:
        rings = np.arange(1, int(reach / _SLOT) + 2) * _SLOT
        counts = (np.pi / np.arcsin(_SLOT / 2 / rings)).astype(np.int64)
        radius = np.repeat(rings, counts)
        number = np.arange(len(radius)) - np.repeat(np.cumsum(counts) - counts, counts)
        turn = (number + 0.5) * 2 * np.pi / np.repeat(counts, counts)
        slots = centre + radius[:, None] * _direction(turn)
        is_free = field.is_free(slots)
        self._slots, self._radius = slots[is_free], radius[is_free]

    def take_nearest(
        self, ideal: NDArray[np.float64], within: float = np.inf
    ) -> NDArray[np.float64] | None:
        """Takes the free spot [2] nearest to the ideal one; None when all are taken.

        A spot `within` this distance from the root is preferred to any beyond.
        """
        if len(self._slots) == 0:
            return None
        gaps = self._slots - ideal
        squares = gaps[:, 0] ** 2 + gaps[:, 1] ** 2
        is_within = self._radius <= within
        if is_within.any():
            squares[~is_within] = np.inf
        spot = self._slots[np.argmin(squares)]
        gaps = self._slots - spot
        kept = gaps[:, 0] ** 2 + gaps[:, 1] ** 2 >= SPACING**2
        self._slots, self._radius = self._slots[kept], self._radius[kept]
        return spot


def ideal_spot(
    centre: NDArray[np.float64],
    parent: NDArray[np.float64],
    n_siblings: int,
    depth: int,
    ring: float | None,
) -> NDArray[np.float64]:
    """Where a new option would stand if it had all the room.

    It continues its parent's direction onto `ring`, the radius of its depth where one is known.
    Children of the root turn by the golden angle, so any number of them spreads evenly.
    """
    offset = parent - centre
    distance = float(np.hypot(*offset))
    if distance < SPACING / 2:
        direction = _direction(np.array(n_siblings * _GOLDEN_ANGLE))
    else:
        direction = offset / distance
    if ring is None or ring <= distance:
        ring = distance + band_gap(max(10, depth))
    return centre + ring * direction


def _direction(angle: NDArray[np.floating]) -> NDArray[np.float64]:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
