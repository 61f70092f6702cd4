"""One mixed-integer linear program of the search for the nearest flip; see `nearest`."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Closer to the end of what is within reach, a place counts as beyond it: the solver drops numbers
# that are smaller still.
_TINY = 1e-7
# What SciPy's `milp` calls the two outcomes.
_OPTIMAL, _INFEASIBLE = 0, 2


@dataclass(frozen=True, eq=False)
class Solution:
    """What a program came to."""

    change: NDArray[np.float64]  # [D]
    bound: float  # On its size.
    is_optimal: bool


class Program:
    """Minimise the size of a change y [D] under linear and distance constraints; see above."""

    def __init__(self, low: NDArray[np.float64], high: NDArray[np.float64], most: float) -> None:
        self._n = n = len(low)
        self._low, self._high = low, high
        # Variables: the change, its size, the distance to the option; then lazily two by two.
        self._lower = [*low, *np.zeros(2 * n)]
        self._upper = [*high, *np.full(2 * n, np.inf)]
        self._is_whole = [0] * (3 * n)
        self._rows: list[dict[int, float]] = []
        self._limits: list[float] = []
        for d in range(n):
            self._add({d: 1.0, n + d: -1.0}, 0.0)
            self._add({d: -1.0, n + d: -1.0}, 0.0)
        self._add({n + d: 1.0 for d in range(n)}, most)

    def _add(self, row: dict[int, float], limit: float) -> None:
        """Adds Σ row · variables ≤ limit."""
        self._rows.append(row)
        self._limits.append(limit)

    def _variable(self, low: float, high: float, *, is_whole: bool) -> int:
        self._lower.append(low)
        self._upper.append(high)
        self._is_whole.append(int(is_whole))
        return len(self._lower) - 1

    def keep_above(self, tilt: NDArray[np.float64], least: float) -> None:
        """Asks that tilt · y be at least so much."""
        self._add({d: -float(tilt[d]) for d in range(self._n)}, -least)

    def stay_near(
        self, tip: NDArray[np.float64], others: NDArray[np.float64], margin: float
    ) -> None:
        """Asks that y be nearer to one tip [D] than to any of the others [k, D], by a margin."""
        n = self._n
        for d in range(n):
            self._add({d: 1.0, 2 * n + d: -1.0}, float(tip[d]))
            self._add({d: -1.0, 2 * n + d: -1.0}, -float(tip[d]))
        for other in others.tolist():
            row, limit = {2 * n + d: 1.0 for d in range(n)}, -margin
            for d, c in enumerate(other):
                if c <= self._low[d] + _TINY:  # |y − c| is y − c all the way.
                    row[d] = row.get(d, 0.0) - 1.0
                    limit -= c
                elif c >= self._high[d] - _TINY:
                    row[d] = row.get(d, 0.0) + 1.0
                    limit += c
                else:
                    row[self._gap_to(d, c)] = -1.0
            self._add(row, limit)

    def _gap_to(self, d: int, c: float) -> int:
        """A variable that is at most |y_d − c|, c being within reach."""
        low, high = float(self._low[d]), float(self._high[d])
        gap = self._variable(0.0, max(c - low, high - c), is_whole=False)
        is_above = self._variable(0.0, 1.0, is_whole=True)
        # Below c the first holds anyway, above it the second.
        self._add({gap: 1.0, d: -1.0, is_above: 2 * (c - low)}, 2 * (c - low) - c)
        self._add({gap: 1.0, d: 1.0, is_above: -2 * (high - c)}, c)
        return gap

    def solve(self, time_limit_s: float) -> Solution | None:
        """The least change; None if there is none."""
        from scipy.optimize import Bounds, LinearConstraint, milp  # noqa: PLC0415  An extra.
        from scipy.sparse import csr_array  # noqa: PLC0415

        entries = [(r, v, x) for r, row in enumerate(self._rows) for v, x in row.items()]
        rows, variables, values = (np.array(column) for column in zip(*entries, strict=True))
        size = len(self._lower)
        matrix = csr_array((values, (rows, variables)), shape=(len(self._rows), size))
        cost = np.zeros(size)
        cost[self._n : 2 * self._n] = 1.0
        lower, upper, limits = (np.array(x) for x in (self._lower, self._upper, self._limits))
        # That there is no solution is believed only if it is found by two ways.
        for presolve in (True, False):
            found: Any = milp(
                cost,
                integrality=np.array(self._is_whole),
                bounds=Bounds(lower, upper),  # pyright: ignore[reportArgumentType]  Arrays, too.
                constraints=LinearConstraint(matrix, -np.inf, limits),  # pyright: ignore[reportArgumentType]
                options={"time_limit": time_limit_s, "mip_rel_gap": 1e-6, "presolve": presolve},
            )
            if found.status != _INFEASIBLE:
                break
        else:
            return None
        if found.status == _OPTIMAL:
            return Solution(np.array(found.x[: self._n]), float(found.fun), is_optimal=True)
        bound = found.mip_dual_bound
        bound = 0.0 if bound is None or not np.isfinite(bound) else float(bound)
        return Solution(np.zeros(self._n), bound, is_optimal=False)
