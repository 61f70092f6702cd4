"""The options where their values are: two or three features as axes of a plane or a box."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

_SIDE = (36.0, 170.0)  # Of the box, for a few options and for many, in the units of the discs.
_TICKS = 5  # About so many numbers along an axis.


@dataclass(frozen=True, eq=False)
class Axes:
    """How features become places; `K` counts the axes, two or three.

    A place is (value - origin) * scale. Both stay as they are for as long as a forest grows: only
    the axes get longer then, nothing moves.
    """

    features: tuple[int, ...]  # [K]
    origin: NDArray[np.float64]  # [K] the value at place 0.
    scale: NDArray[np.float64]  # [K] places in a unit of the feature.
    low: NDArray[np.float64]  # [K] the smallest value that the axis shows.
    high: NDArray[np.float64]  # [K]

    def place(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """[..., 3] where values [..., D] stand; the third is 0 if there are two axes."""
        places = np.zeros((*values.shape[:-1], 3))
        chosen = values[..., list(self.features)]
        places[..., : len(self.features)] = (chosen - self.origin) * self.scale
        return places

    @property
    def box(self) -> NDArray[np.float64]:
        """[2, 3] the lowest and the highest corner."""
        corners = np.zeros((2, 3))
        for row, values in enumerate((self.low, self.high)):
            corners[row, : len(self.features)] = (values - self.origin) * self.scale
        return corners


def fit_axes(values: NDArray[np.float64], features: tuple[int, ...]) -> Axes:
    """Axes for options with these values [M, D], which fill a square or a cube."""
    low, high = _range(values[:, list(features)], len(features))
    fewest, most = _SIDE
    side = float(np.clip(2.0 * np.sqrt(len(values)), fewest, most))
    return Axes(features, (low + high) / 2, side / (high - low), low, high)


def extend_axes(axes: Axes, values: NDArray[np.float64]) -> Axes:
    """The axes made just long enough for these values [M, D] as well."""
    if len(values) == 0:
        return axes
    chosen = values[:, list(axes.features)]
    low, high = np.minimum(axes.low, chosen.min(axis=0)), np.maximum(axes.high, chosen.max(axis=0))
    if (low == axes.low).all() and (high == axes.high).all():
        return axes
    return replace(axes, low=low, high=high)


def find_ticks(low: float, high: float) -> NDArray[np.float64]:
    """Round numbers between two ends, about five: steps of 1, 2 or 5 times a power of ten."""
    rough = (high - low) / _TICKS
    if not np.isfinite(rough) or rough <= 0:
        return np.array([low])
    power = 10.0 ** np.floor(np.log10(rough))
    step = power * next(n for n in (1, 2, 5, 10) if n * power >= rough * (1 - 1e-9))
    first = np.ceil(low / step - 1e-9)
    steps = np.arange(first, np.floor(high / step + 1e-9) + 1)
    return steps * step if len(steps) else np.array([low])


def _range(chosen: NDArray[np.float64], n_axes: int) -> tuple[NDArray, NDArray]:
    if len(chosen) == 0:
        return -np.ones(n_axes), np.ones(n_axes)
    low, high = chosen.min(axis=0), chosen.max(axis=0)
    # A feature that never varied still gets an axis, with its one value in the middle.
    half = np.where(high > low, (high - low) / 2, np.maximum(np.abs(low), 1.0) / 2)
    middle = (low + high) / 2
    return middle - 1.04 * half, middle + 1.04 * half
