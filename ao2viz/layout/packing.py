"""Circles packed side by side around the first one."""

import numpy as np
from numpy.typing import NDArray


def pack_circles(radii: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centres [S, 2] of circles that touch but never overlap, the first one at the origin.

    Give the biggest first. Each circle is laid into the notch between two neighbours on the rim
    of what is already placed, as close to the origin as it fits (the front chain of Wang, Wang,
    Dai and Wang, 2006), so a thousand circles take a moment only.
    """
    centres = np.zeros((len(radii), 2))
    if len(radii) < 2:
        return centres
    centres[1] = (radii[0] + radii[1], 0.0)
    if len(radii) == 2:
        return centres
    # `after[i]` and `before[i]` walk the rim counter-clockwise; its outside is on the right.
    after, before = {0: 1, 1: 0}, {0: 1, 1: 0}
    x, y, r = centres[:, 0].tolist(), centres[:, 1].tolist(), [float(v) for v in radii]
    for new in range(2, len(r)):
        a = min(after, key=lambda i: _pull(i, after[i], x, y, r))
        b = after[a]
        while True:
            x[new], y[new] = _notch(a, b, r[new], x, y, r)
            clash = _first_clash(new, a, b, after, before, x, y, r)
            if clash is None:
                break
            hit, is_ahead = clash
            a, b = (a, hit) if is_ahead else (hit, b)
            _cut(a, b, after, before)
        after[a], before[new], after[new], before[b] = new, a, b, new
    return np.column_stack([x, y])


def _pull(i: int, j: int, x: list[float], y: list[float], r: list[float]) -> float:
    """How far the touching point of two rim circles is from the origin, squared."""
    share = r[i] / (r[i] + r[j])
    return (x[i] + (x[j] - x[i]) * share) ** 2 + (y[i] + (y[j] - y[i]) * share) ** 2


def _notch(
    a: int, b: int, radius: float, x: list[float], y: list[float], r: list[float]
) -> tuple[float, float]:
    """Where a circle touches both a and b, right of the way from a to b."""
    dx, dy = x[b] - x[a], y[b] - y[a]
    gap = dx * dx + dy * dy
    to_a, to_b = (r[a] + radius) ** 2, (r[b] + radius) ** 2
    along = (gap + to_a - to_b) / (2 * gap)
    across = max(0.0, to_a / gap - along * along) ** 0.5
    return x[a] + along * dx + across * dy, y[a] + along * dy - across * dx


def _first_clash(
    new: int,
    a: int,
    b: int,
    after: dict[int, int],
    before: dict[int, int],
    x: list[float],
    y: list[float],
    r: list[float],
) -> tuple[int, bool] | None:
    """The overlapped rim circle nearest along the rim, and whether it lies ahead of b."""
    ahead, behind = after[b], before[a]
    way_ahead, way_behind = r[b], r[a]
    for _ in range(len(after)):
        if ahead == a or behind == b:
            # The two walks have met: look at what is left on the longer side, then stop.
            ahead = behind = -1
        if ahead < 0:
            break
        if way_ahead <= way_behind:
            if _overlaps(new, ahead, x, y, r):
                return ahead, True
            way_ahead += r[ahead]
            if ahead == behind:
                break
            ahead = after[ahead]
        else:
            if _overlaps(new, behind, x, y, r):
                return behind, False
            way_behind += r[behind]
            if ahead == behind:
                break
            behind = before[behind]
    return None


def _overlaps(i: int, j: int, x: list[float], y: list[float], r: list[float]) -> bool:
    reach = r[i] + r[j] - 1e-6
    return reach > 0 and reach * reach > (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2


def _cut(a: int, b: int, after: dict[int, int], before: dict[int, int]) -> None:
    """Takes the circles between a and b off the rim."""
    between = after[a]
    while between != b:
        following = after[between]
        del after[between], before[between]
        between = following
    after[a], before[b] = b, a
