"""Saved state as plain arrays by name, checked when it comes back."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import DTypeLike, NDArray

Arrays = dict[str, NDArray]
"""Everything a learner must keep to continue to the bit; plain arrays only."""


def take_array(
    state: Mapping[str, NDArray], name: str, shape: tuple[int | None, ...], dtype: DTypeLike
) -> NDArray:
    """An array of a saved state, checked; None in the shape stands for any length.

    Raises:
        ValueError: If it is missing or of another shape or kind.
    """
    if name not in state:
        raise ValueError(f"Expected an array {name!r}, but there is none.")
    array = state[name]
    fits = array.ndim == len(shape) and all(
        want is None or want == got for want, got in zip(shape, array.shape, strict=True)
    )
    if not fits or array.dtype != np.dtype(dtype):
        raise ValueError(
            f"Expected array {name!r} of shape {shape} and type {np.dtype(dtype)}, but it has "
            f"shape {array.shape} and type {array.dtype}."
        )
    return array
