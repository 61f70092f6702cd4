"""Local linear regression: planes fitted to the options around a place, the nearest the loudest."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.compiled import compiled


class Workspace(NamedTuple):
    """Work space for one query with at most K options of D features; allocated once."""

    ids: NDArray[np.int64]  # [K]
    distances: NDArray[np.float64]  # [K]
    kernel: NDArray[np.float64]  # [K] closeness of each option, in [0, 1].
    offsets: NDArray[np.float64]  # [K, D] from the query, in kernel widths.
    normal: NDArray[np.float64]  # [D + 1, D + 1]
    solution: NDArray[np.float64]  # [D + 1]
    shares: NDArray[np.float64]  # [K]
    slopes: NDArray[np.float64]  # [A, D] of the actions' weights, per unit of scaled distance.
    effect: NDArray[np.float64]  # [D + 2] displacement, reward, chance of ending.
    state: NDArray[np.float64]  # [D] where an imagination has got to.


def make_workspace(voters: int, n_features: int, n_actions: int) -> Workspace:
    """Work space for so many voters in forests of so many features and actions."""
    return Workspace(
        np.empty(voters, np.int64),
        np.empty(voters),
        np.empty(voters),
        np.empty((voters, n_features)),
        np.empty((n_features + 1, n_features + 1)),
        np.empty(n_features + 1),
        np.empty(voters),
        np.zeros((n_actions, n_features)),
        np.empty(n_features + 2),
        np.empty(n_features),
    )


@compiled
def sharp_closeness(d: float, width: float) -> float:
    """Weight of an option at distance d while imagining: only what is near tells what follows."""
    gap = 1.0 - d / width
    return gap * gap if gap > 0.0 else 0.0


@compiled
def broad_closeness(d: float, width: float) -> float:
    """Weight of an option at distance d while deciding: many voters even out each one's error.

    The tricube kernel of Cleveland (1979), 1 at the query and 0 at the kernel width.
    """
    gap = 1.0 - (d / width) ** 3
    return gap * gap * gap if gap > 0.0 else 0.0


@compiled
def factor_local_linear(work: Workspace, count: int, ridge: float) -> None:
    """Readies `normal` for a local linear regression around the query.

    Reads `kernel` and `offsets`; `normal` becomes the Cholesky factor (lower triangle) of the
    normal equations, with a ridge on the slopes.
    """
    d1 = work.offsets.shape[1] + 1
    a = work.normal
    total = 0.0
    for i in range(d1):
        for j in range(i + 1):
            a[i, j] = 0.0
    for n in range(count):
        k = work.kernel[n]
        if k == 0.0:
            continue
        total += k
        for i in range(1, d1):
            ki = k * work.offsets[n, i - 1]
            a[i, 0] += ki
            for j in range(1, i + 1):
                a[i, j] += ki * work.offsets[n, j - 1]
    a[0, 0] = total
    for i in range(1, d1):
        a[i, i] += ridge * total
    # The ridge keeps every pivot positive.
    for j in range(d1):
        s = a[j, j]
        for k2 in range(j):
            s -= a[j, k2] * a[j, k2]
        a[j, j] = np.sqrt(max(s, 1e-12 * total))
        for i in range(j + 1, d1):
            s = a[i, j]
            for k2 in range(j):
                s -= a[i, k2] * a[j, k2]
            a[i, j] = s / a[j, j]


@compiled
def solve_factored(work: Workspace) -> None:
    """Solves the equations readied by `factor_local_linear` for `solution`, in place."""
    a, c = work.normal, work.solution
    d1 = c.shape[0]
    for i in range(d1):
        s = c[i]
        for j in range(i):
            s -= a[i, j] * c[j]
        c[i] = s / a[i, i]
    for i in range(d1 - 1, -1, -1):
        s = c[i]
        for j in range(i + 1, d1):
            s -= a[j, i] * c[j]
        c[i] = s / a[i, i]


@compiled
def solve_local_linear(work: Workspace, count: int, ridge: float) -> None:
    """Shares whose weighted sum is the local linear (ridge) regression's value at the query.

    Reads `kernel` and `offsets`, writes `shares`, which add up to 1 but may be negative. Source:
    Hastie, Tibshirani and Friedman, The Elements of Statistical Learning, section 6.1.1
    (equivalent kernel), with a ridge on the slopes.
    """
    c = work.solution
    factor_local_linear(work, count, ridge)
    c[:] = 0.0
    c[0] = 1.0
    solve_factored(work)
    for n in range(count):
        s = c[0]
        for i in range(1, c.shape[0]):
            s += c[i] * work.offsets[n, i - 1]
        work.shares[n] = s * work.kernel[n]


@compiled
def fit_planes(
    heights: NDArray[np.float64],
    count: int,
    width: float,
    ridge: float,
    work: Workspace,
    levels: NDArray[np.float64],
) -> None:
    """Fits one plane for each column of `heights` [N, A] through the options in the work space.

    Reads `ids`, `kernel` and `offsets`, which are in units of `width`. Writes how high the planes
    are at the query into `levels` [A], and how steep along each feature into `slopes`.
    """
    factor_local_linear(work, count, ridge)
    n_features = work.offsets.shape[1]
    for a in range(levels.shape[0]):
        work.solution[:] = 0.0
        for n in range(count):
            loud = work.kernel[n] * heights[work.ids[n], a]
            work.solution[0] += loud
            for d in range(n_features):
                work.solution[d + 1] += loud * work.offsets[n, d]
        solve_factored(work)
        levels[a] = work.solution[0]
        for d in range(n_features):
            work.slopes[a, d] = work.solution[d + 1] / width
