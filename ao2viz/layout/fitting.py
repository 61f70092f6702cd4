"""A window around a picture: as close as it can be without a panel covering any of it."""

import numpy as np
from numpy.typing import NDArray

_ROUNDS = 18  # Halvings of the range in which the scale is searched.
_PLACES = 13  # Offsets tried along each direction.
_MOST = 300  # More circles than this are gathered …
_CELLS = 22  # … by the cells of a grid, so many along each direction.


def fit_window(
    circles: NDArray[np.float64],
    window: tuple[float, float],
    panel: tuple[float, float],
    margin: float,
) -> tuple[float, tuple[float, float]]:
    """Where to look so that every circle is seen whole, beside the panel, and as big as can be.

    Args:
        circles: [S, 3] x, y and radius of what is to be seen, y going up.
        window: Width and height in pixels.
        panel: Width and height of what covers the lower left corner, in pixels, 0 for nothing.
        margin: Kept free at the rim of the window, in pixels.

    Returns:
        Pixels in a unit, and what point (x, y) stands in the middle of the window.
    """
    if len(circles) == 0:
        circles = np.array([[0.0, 0.0, 10.0]])
    circles = _gather(circles)
    reach = circles[:, 2:]
    low, high = (circles[:, :2] - reach).min(axis=0), (circles[:, :2] + reach).max(axis=0)
    room = np.maximum(np.array(window) - 2 * margin, 1.0)
    largest = float((room / np.maximum(high - low, 1e-9)).min())
    # A panel so big that nothing fits beside it is ignored: a small picture helps nobody.
    smallest = 0.45 * largest
    best = _find_offset(circles, smallest, (low, high), window, panel, margin)
    if best is None:
        return largest, (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2)
    below, above = smallest, largest
    if (at_most := _find_offset(circles, largest, (low, high), window, panel, margin)) is not None:
        return largest, at_most
    for _ in range(_ROUNDS):
        middle = (below + above) / 2
        found = _find_offset(circles, middle, (low, high), window, panel, margin)
        if found is None:
            above = middle
        else:
            below, best = middle, found
    return below, best


def _gather(circles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Not many circles, which cover all of these."""
    if len(circles) <= _MOST:
        return circles
    low, high = circles[:, :2].min(axis=0), circles[:, :2].max(axis=0)
    size = np.maximum(high - low, 1e-9) / _CELLS
    cells = np.minimum(((circles[:, :2] - low) / size).astype(np.int64), _CELLS - 1)
    cells, cell_of = np.unique(cells, axis=0, return_inverse=True)
    middles, radii = low + (cells + 0.5) * size, np.zeros(len(cells))
    away = np.hypot(*(circles[:, :2] - middles[cell_of]).T) + circles[:, 2]
    np.maximum.at(radii, cell_of, away)
    return np.column_stack([middles, radii])


def _find_offset(
    circles: NDArray[np.float64],
    scale: float,
    ends: tuple[NDArray[np.float64], NDArray[np.float64]],
    window: tuple[float, float],
    panel: tuple[float, float],
    margin: float,
) -> tuple[float, float] | None:
    """The middle of the window at which no circle meets the panel, closest to the picture's."""
    low, high = ends
    half = (np.array(window) / 2 - margin) / scale
    # Between these the whole picture is inside the window.
    spots = [np.linspace(h - r, lo + r, _PLACES) for lo, h, r in zip(low, high, half, strict=True)]
    middles = np.stack(np.meshgrid(*spots), axis=-1).reshape(-1, 2)
    away = np.hypot(*(middles - (low + high) / 2).T)
    middles = middles[np.argsort(away, kind="stable")]
    if min(panel) <= 0:
        return float(middles[0, 0]), float(middles[0, 1])
    corner = middles - np.array(window) / 2 / scale  # Of the window, lower left.
    inner = corner + (np.array(panel) + margin) / scale  # Of the panel, upper right.
    gaps = np.maximum(circles[None, :, :2] - inner[:, None], 0)
    free = (np.hypot(gaps[..., 0], gaps[..., 1]) >= circles[None, :, 2]).all(axis=1)
    if not free.any():
        return None
    x, y = middles[int(np.argmax(free))]
    return float(x), float(y)
