"""Discs raised into cones: the further below its root an option is, the lower it stands."""

import numpy as np
from numpy.typing import NDArray

_STEP = 9.0  # From one depth to the next, in the units of the discs.
_EVEN = 6  # Down to this depth the steps are even; below they shrink, so that no cone is a pole.


def find_heights(depths: NDArray[np.int64]) -> NDArray[np.float64]:
    """[N] how high options of these depths stand: 0 at a root, and always lower below.

    A height depends on the depth alone, so nothing moves while a forest grows.
    """
    deep = np.maximum(depths, _EVEN).astype(np.float64)
    return -_STEP * (np.minimum(depths, _EVEN) + _EVEN * np.log(deep / _EVEN))
