"""Learners that went before, laid behind the returns of a training run."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from ao2viz.figures.bands import band
from ao2viz.figures.palette import ACTIONS, DARK, Palette, Rgb, action_colors, to_hex

_LINE_OPACITY = 0.85
_HERE: str = "you are here"


@dataclass(frozen=True, eq=False)
class Behind:
    """How one learner learned one task; `S` counts seeds, `C` checkpoints."""

    env: str
    learner: str  # As people read it.
    rank: int  # Among all learners there are curves of; a learner has one on every task.
    steps: NDArray[np.int64]  # [C] rising, all above 0; of the environment.
    seeds: tuple[int, ...]  # [S] rising.
    returns: NDArray[np.float64]  # [S, C] mean return of the evaluation episodes.

    @property
    def mean(self) -> NDArray[np.float64]:
        """[C] over seeds."""
        return self.returns.mean(axis=0)

    @property
    def color(self) -> Rgb:
        """The same on every task; beyond the sixth they repeat, darkened, see `is_dashed`."""
        return self.color_in(DARK)

    def color_in(self, palette: Palette) -> Rgb:
        """The same on a page of other colours."""
        r, g, b = action_colors(self.rank + 1, is_ordered=False, palette=palette)[self.rank]
        return int(r), int(g), int(b)

    @property
    def is_dashed(self) -> bool:
        """Whether its hue is another learner's as well."""
        return self.rank >= len(ACTIONS)

    def by(self, steps: float) -> int | None:
        """The latest checkpoint at or before so many steps; None before the first."""
        place = int(np.searchsorted(self.steps, steps, side="right")) - 1
        return place if place >= 0 else None

    def first_at(self, level: float) -> int | None:
        """The first checkpoint whose mean is at least so high; None if none is."""
        there = np.flatnonzero(self.mean >= level)
        return int(there[0]) if len(there) else None


@dataclass(frozen=True)
class Here:
    """Where the run is that learners are laid behind."""

    steps: int  # At the end of its latest episode.
    value: float  # Mean return of its latest episodes.
    episodes: int  # How many those are.


def here_of(history: NDArray[np.float64], smoothing: int) -> Here | None:
    """The end of the running mean that the chart shows; None before the first episode's end.

    Args:
        history: [E, 4] as in `History`.
        smoothing: Episodes in the running mean.
    """
    if len(history) == 0:
        return None
    latest = history[-smoothing:, 1]
    return Here(int(history[-1, 0]), float(latest.mean()), len(latest))


def lay_behind(
    figure: go.Figure, learners: Sequence[Behind], here: Here | None, palette: Palette = DARK
) -> None:
    """Draws learners behind all that a figure over steps shows already, and marks where the run is.

    A line is the mean over seeds, its band reaches from the worst seed to the best. Steps become
    logarithmic, since learners need very different numbers of them, and the run's own lines lose
    their colours, which are now learners'.
    """
    if not learners:
        return
    ink = figure.layout.font.color
    own: Any = figure.data  # plotly's own types say less than is there.
    for trace in own:
        trace.line.color = ink
    for learner in learners:
        returns = learner.returns
        low, high = returns.min(axis=0), returns.max(axis=0)
        figure.add_trace(band(learner.steps, low, high, learner.color_in(palette)))
    for learner in learners:
        figure.add_trace(_line(learner, palette))
    traces: Any = figure.data
    figure.data = (*traces[len(own) :], *traces[: len(own)])
    # Only powers of ten are written out: there is room for no more.
    figure.update_xaxes(type="log", dtick=1, tickformat="~s")
    figure.update_layout(hovermode="closest")
    if here is None:
        return
    figure.add_vline(x=here.steps, line={"color": ink, "width": 1, "dash": "dot"})
    figure.add_scatter(
        x=[here.steps],
        y=[here.value],
        mode="markers+text",
        marker={"size": 9, "symbol": "diamond", "color": ink, "line": {"width": 1}},
        text=[_HERE],
        textposition="top left" if here.steps > learners[0].steps[0] else "top right",
        textfont={"color": ink, "size": 11},
        hovertemplate=f"{_HERE}: %{{y:.1f}} after %{{x:,}} steps<extra></extra>",
        showlegend=False,
    )


def _line(learner: Behind, palette: Palette) -> go.Scatter:
    dash = "dash" if learner.is_dashed else "solid"
    return go.Scatter(
        x=learner.steps,
        y=learner.mean,
        name=learner.learner,
        mode="lines+markers",
        line={"color": to_hex(learner.color_in(palette)), "width": 2, "dash": dash},
        marker={"size": 4},
        opacity=_LINE_OPACITY,
        showlegend=False,
        hovertemplate="%{y:.1f} after %{x:,} steps<extra>" + learner.learner + "</extra>",
    )
