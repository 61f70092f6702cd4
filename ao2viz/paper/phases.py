"""Where a training curve jumps: the best division into stretches of constant level."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Phase:
    """A stretch of a curve."""

    first: int  # Index of its first value …
    past: int  # … and the one after its last.
    level: float  # Its mean.


def find_phases(values: NDArray[np.float64], count: int) -> list[Phase]:
    """The division into `count` stretches whose squared distances from their means are least.

    Exact, by dynamic programming (Bellman and Roth 1969). As many stretches come out as are asked
    for, whether the curve has jumps or not: look at the levels.

    Raises:
        ValueError: If there are fewer values than stretches.
    """
    n = len(values)
    if not 1 <= count <= n:
        raise ValueError(f"Expected 1 to {n} phases of {n} values, but got {count}.")
    sums = np.concatenate([[0.0], np.cumsum(values)])
    squares = np.concatenate([[0.0], np.cumsum(values**2)])

    def cost(first: int, past: int) -> float:
        total = sums[past] - sums[first]
        return float(squares[past] - squares[first] - total**2 / (past - first))

    # best[k][p]: the least cost of the first p values in k stretches, and where the last begins.
    best = {(0, 0): (0.0, 0)}
    for k in range(1, count + 1):
        for past in range(k, n + 1):
            best[k, past] = min(
                (best[k - 1, first][0] + cost(first, past), first)
                for first in range(k - 1, past)
                if (k - 1, first) in best
            )
    phases, past = [], n
    for k in range(count, 0, -1):
        first = best[k, past][1]
        phases.append(Phase(first, past, float(values[first:past].mean())))
        past = first
    return phases[::-1]
