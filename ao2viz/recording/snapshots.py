"""What a forest knew at some moments of its life: weights and visits now and then, bounded."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.forest import ForestView

FIRST_STRIDE = 256
"""Steps between two snapshots at first; it doubles whenever there are too many, or too big ones."""
MAX_SNAPSHOTS = 32
MAX_BYTES = 2**20
"""All snapshots together, in memory; a forest so big that one does not fit has none."""

_TYPES = {
    "stride": np.int64,
    "steps": np.int64,
    "rows": np.int64,
    "attention": np.float64,
    "weights": np.float32,
    "visits": np.int32,
}


@dataclass(frozen=True, eq=False)
class Snapshot:
    """What the options knew at one moment; structure is the growth log's."""

    step: int
    attention: NDArray[np.float64]  # [D]
    weights: NDArray[np.float32]  # [N, A] of the options that there had ever been.
    visits: NDArray[np.int32]  # [N, A]

    @property
    def n_bytes(self) -> int:
        """What it takes in memory."""
        return self.attention.nbytes + self.weights.nbytes + self.visits.nbytes


class Snapshots:
    """Snapshots at every multiple of a stride. Mutable: one owner.

    Which moments are kept depends on steps and sizes alone, so the same run keeps the same ones,
    whether it was interrupted or not.
    """

    def __init__(self) -> None:
        self.stride = FIRST_STRIDE
        self._kept: list[Snapshot] = []

    def __len__(self) -> int:
        """Snapshots kept."""
        return len(self._kept)

    @property
    def kept(self) -> tuple[Snapshot, ...]:
        """The oldest first."""
        return tuple(self._kept)

    def is_due(self, step: int) -> bool:
        """Whether a snapshot should be taken before anything happens after this step."""
        is_new = not self._kept or self._kept[-1].step < step
        return step > 0 and step % self.stride == 0 and is_new

    def take(self, view: ForestView, step: int) -> None:
        """Keeps what the forest knows after this step, and thins the others out if need be."""
        self._kept.append(
            Snapshot(
                step,
                np.array(view.attention),
                view.weights.astype(np.float32),
                view.visits.astype(np.int32),
            )
        )
        while self._kept and self._is_too_much():
            self.stride *= 2
            self._kept = [one for one in self._kept if one.step % self.stride == 0]

    def to_arrays(self) -> dict[str, NDArray]:
        """Plain arrays, the options of all snapshots below one another; `from_arrays` reads."""
        kept = self._kept
        if not kept:
            return {}
        columns = {
            "stride": self.stride,
            "steps": [one.step for one in kept],
            "rows": [len(one.weights) for one in kept],
            "attention": [one.attention for one in kept],
            "weights": np.concatenate([one.weights for one in kept]),
            "visits": np.concatenate([one.visits for one in kept]),
        }
        return {name: np.array(column, _TYPES[name]) for name, column in columns.items()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray]) -> Self:
        """The snapshots that `to_arrays` wrote; without arrays there are none.

        Raises:
            ValueError: If they do not fit one another.
        """
        snapshots = cls()
        if not arrays:
            return snapshots
        types = {name: array.dtype for name, array in arrays.items()}
        if types != {name: np.dtype(kind) for name, kind in _TYPES.items()}:
            raise ValueError(f"Expected snapshots as {', '.join(_TYPES)}, each of its type.")
        steps, rows = arrays["steps"], arrays["rows"]
        weights, visits, attention = arrays["weights"], arrays["visits"], arrays["attention"]
        if not (
            arrays["stride"].shape == ()
            and arrays["stride"] > 0
            and steps.shape == rows.shape == (len(attention),)
            and 0 < len(steps) <= MAX_SNAPSHOTS
            and (rows >= 0).all()
            and (steps > 0).all()
            and (np.diff(steps) > 0).all()
            and (np.diff(rows) >= 0).all()
            and attention.ndim == weights.ndim == 2
            and weights.shape == visits.shape == (rows.sum(), weights.shape[1])
            and np.isfinite(weights).all()
            and np.isfinite(attention).all()
            and (attention >= 0).all()
            and (visits >= 0).all()
        ):
            raise ValueError("Expected sound snapshots of a forest, the oldest first.")
        snapshots.stride = int(arrays["stride"])
        ends = np.cumsum(rows)
        snapshots._kept = [
            Snapshot(int(step), attention[i], weights[end - n : end], visits[end - n : end])
            for i, (step, n, end) in enumerate(zip(steps, rows, ends, strict=True))
        ]
        return snapshots

    def _is_too_much(self) -> bool:
        return len(self._kept) > MAX_SNAPSHOTS or sum(o.n_bytes for o in self._kept) > MAX_BYTES
