"""What the colour of an option says: one of five things, each with a scale to read it by."""

from dataclasses import dataclass
from enum import Enum
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import count, number
from ao2viz.figures.palette import DARK, Palette, action_colors, along_ramp

NEIGHBOURS = 8
"""Agreement asks so many of the most similar options."""

MOST_COMPARED = 50_000
"""Options whose agreement can be told: each is compared with all others."""

_AT_A_TIME = 256  # Options whose distances to all others are in memory at once.
_RANKS = 101  # So many quantiles of the values are told apart.


class Coloring(Enum):
    """What colours tell; the values are what people read."""

    ACTION = "preferred action"
    VALUE = "value"
    VISITS = "visits"
    AGE = "age"
    AGREEMENT = "agreement"


@dataclass(frozen=True, eq=False)
class Shades:
    """A colour for every option, and how to read the colours."""

    colors: NDArray[np.uint8]  # [N, 3]
    marks: tuple[str, ...] | None  # Said along the colours, dark to bright; None: one an action.


def shade(
    view: ForestView,
    spec: TaskSpec,
    coloring: Coloring,
    agreement: NDArray[np.float64] | None = None,
    palette: Palette = DARK,
) -> Shades:
    """Colours every option, grey where there is nothing to tell.

    Args:
        view: The forest.
        spec: Tells whether its actions have an order.
        coloring: What the colours are to tell.
        agreement: [N] as `find_agreement` gives it, for that colouring; None: not known yet.
        palette: The colours to choose from.
    """
    tried = view.visits.sum(axis=1) > 0
    match coloring:
        case Coloring.ACTION:
            is_ordered = spec.action_grid is not None
            hues = action_colors(spec.n_actions, is_ordered=is_ordered, palette=palette)
            grey = np.array(palette.untried, np.uint8)
            return Shades(np.where(tried[:, None], hues[view.best_actions], grey), None)
        case Coloring.VALUE:
            asked = tried & view.is_alive
            values = view.weights.max(axis=1)
            scale = _quantiles(values[asked])
            # By rank: most options expect almost the same, and few much more or less.
            at = np.interp(values, scale, np.linspace(0, 1, len(scale)))
            marks = number(scale[0]), number(scale[len(scale) // 2]), number(scale[-1])
            return Shades(_along(at, 0.0, 1.0, tried, palette), marks)
        case Coloring.VISITS:
            visits = view.visits.sum(axis=1)
            most = int(visits.max(initial=1))
            logs = np.log2(np.maximum(visits, 1))
            middle = f"{round(np.sqrt(most)):,}"
            marks = "1 visit", middle, count(most, "visit")
            return Shades(_along(logs, 0.0, np.log2(most), tried, palette), marks)
        case Coloring.AGE:
            first, last = _ends(view.born[view.is_alive])
            marks = f"step {int(first):,}", f"step {int(last):,}"
            born = view.born.astype(float)
            return Shades(_along(born, first, last, view.is_alive, palette), marks)
        case Coloring.AGREEMENT:
            shares = np.full(len(tried), np.nan)
            if agreement is not None:
                shares[: len(agreement)] = agreement[: len(shares)]
            known = ~np.isnan(shares)
            return Shades(_along(shares, 0.0, 1.0, known, palette), ("none", "half", "all"))
        case _:
            assert_never(coloring)


def find_agreement(view: ForestView) -> NDArray[np.float64]:
    """[N] which share of an option's most similar options prefers the same action; NaN: untried.

    Asks the NEIGHBOURS nearest living options that have tried anything. Every distance is
    measured, so this takes a second or two for ten thousand options, and of more than MOST_COMPARED
    nothing is told.
    """
    shares = np.full(len(view.parents), np.nan)
    asked = np.flatnonzero(view.is_alive & view.visits.any(axis=1))
    if not 2 <= len(asked) <= MOST_COMPARED:
        return shares
    scaled = (view.values[asked] * view.attention).astype(np.float32)
    best, wanted = view.best_actions[asked], min(NEIGHBOURS, len(asked) - 1)
    for start in range(0, len(asked), _AT_A_TIME):
        some = np.arange(start, min(start + _AT_A_TIME, len(asked)))
        gaps = np.zeros((len(some), len(asked)), np.float32)
        for feature in scaled.T:
            gaps += np.abs(feature[some, None] - feature[None])
        gaps[np.arange(len(some)), some] = np.inf
        near = np.argpartition(gaps, wanted - 1, axis=1)[:, :wanted]
        shares[asked[some]] = (best[near] == best[some, None]).mean(axis=1)
    return shares


def _along(
    values: NDArray[np.float64],
    low: float,
    high: float,
    is_known: NDArray[np.bool_],
    palette: Palette,
) -> NDArray[np.uint8]:
    at = np.zeros(len(values)) if high <= low else (values - low) / (high - low)
    colors = along_ramp(np.where(is_known, np.nan_to_num(at), 0.0), palette)
    return np.where(is_known[:, None], colors, np.array(palette.untried, np.uint8))


def _quantiles(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rising values that part the others into equally many; what occurs often is there once."""
    if len(values) == 0:
        return np.zeros(1)
    return np.unique(np.quantile(values, np.linspace(0, 1, _RANKS), method="nearest"))


def _ends(values: NDArray) -> tuple[float, float]:
    return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
