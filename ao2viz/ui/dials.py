"""The ends and steps of the controls that stand for features, in the units that people read."""

import math
from dataclasses import dataclass

import numpy as np

from ao2viz.core.forest import ForestView
from ao2viz.envs.catalogue import Feature
from ao2viz.envs.ranges import Ranges
from ao2viz.envs.task import TaskSpec

_STEPS = 1000  # About so many fit on a control.


@dataclass(frozen=True)
class Dial:
    """The control of one feature; numbers as shown, which is observed · scale."""

    low: float
    high: float
    step: float
    digits: int  # Decimals that tell steps apart.

    def nearest(self, shown: float) -> float:
        """The place of the control that stands for a number; its end for what lies beyond."""
        held = min(max(shown, self.low), self.high)
        return min(
            max(round(round(held / self.step) * self.step, self.digits), self.low), self.high
        )


def make_dials(view: ForestView, ranges: Ranges, spec: TaskSpec) -> tuple[Dial, ...]:
    """[D] a control for each feature, within what the environment allows.

    Where it sets no bounds, the control goes as far as what the options stand for, and half as
    much again on both sides.
    """
    values = view.values[view.is_alive]
    dials = []
    for d, feature in enumerate(spec.features):
        met = values[:, d] if len(values) else np.zeros(1)
        spare = (float(met.max()) - float(met.min())) / 2 or 1.0
        low, high = float(ranges.low[d]), float(ranges.high[d])
        low = low if np.isfinite(low) else float(met.min()) - spare
        high = high if np.isfinite(high) else float(met.max()) + spare
        dials.append(_make_dial(low, high, feature))
    return tuple(dials)


def _make_dial(low: float, high: float, feature: Feature) -> Dial:
    ends = sorted((low * feature.scale, high * feature.scale))
    rough = max((ends[1] - ends[0]) / _STEPS, 1e-9)
    size = math.floor(math.log10(rough))
    step = next(n * 10.0**size for n in (1, 2, 5, 10) if n * 10.0**size >= rough)
    digits = max(0, -math.floor(math.log10(step)))
    # Inwards, for beyond its ends the environment allows nothing; a hair is for rounding.
    first = round(math.ceil(ends[0] / step - 1e-6) * step, digits)
    last = round(math.floor(ends[1] / step + 1e-6) * step, digits)
    return Dial(first, max(last, first), round(step, digits), digits)
