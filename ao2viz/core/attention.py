"""Attention: how much each feature counts, found at first from how much it varies."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.compiled import compiled


class RunningSpread:
    """Mean and standard deviation of every observation so far (Welford, 1962).

    `D` counts features. Kept as one array so that it is saved as it is.
    """

    def __init__(self, n_features: int) -> None:
        self.moments = np.zeros((3, n_features))  # Count, mean, sum of squared gaps.

    def add(self, observation: NDArray[np.float64]) -> None:
        """Takes one more observation [D] into account."""
        _add(self.moments, observation)

    @property
    def deviation(self) -> NDArray[np.float64]:
        """[D] standard deviations; 0 before the second observation."""
        return np.sqrt(self.moments[2] / np.maximum(self.moments[0], 1))


@compiled
def _add(moments: NDArray[np.float64], observation: NDArray[np.float64]) -> None:
    for d in range(observation.shape[0]):
        moments[0, d] += 1.0
        gap = observation[d] - moments[1, d]
        moments[1, d] += gap / moments[0, d]
        moments[2, d] += gap * (observation[d] - moments[1, d])


def attention_from(deviation: NDArray[np.float64], width: float) -> NDArray[np.float64]:
    """[D] weights under which `width` standard deviations are one unit of distance.

    A feature that never varied tells nothing apart and gets weight 0.
    """
    varies = deviation > 1e-12
    return np.where(varies, 1.0 / (width * np.where(varies, deviation, 1.0)), 0.0)


def has_changed(old: NDArray[np.float64], new: NDArray[np.float64], factor: float) -> bool:
    """Whether any feature's attention [D] is `factor` times what it was, or less than 1/factor."""
    if ((old > 0) != (new > 0)).any():
        return True
    ratio = new[old > 0] / old[old > 0]
    return bool((np.maximum(ratio, 1.0 / ratio) > factor).any())
