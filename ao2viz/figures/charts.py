"""How training went, and what an option expects: plotly figures that read on dark and on light."""

from enum import Enum
from typing import assert_never

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from ao2viz.envs.task import TaskSpec
from ao2viz.figures.palette import DARK, Palette, Rgb, action_colors, to_hex

MAX_POINTS = 2_000
"""More points than a chart has pixels are thinned out."""

SMOOTH_EPISODES = 20
"""The running mean is over so many episodes unless asked otherwise."""


class Over(Enum):
    """What training is measured by; the values are what people read."""

    STEPS = "steps"
    EPISODES = "episodes"
    SECONDS = "seconds"


def places_on(
    over: Over, history: NDArray[np.float64], seconds: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """[E] where each training episode stands on the axis; NaN if nobody knows."""
    match over:
        case Over.STEPS:
            return history[:, 0]
        case Over.EPISODES:
            return np.arange(1.0, len(history) + 1)
        case Over.SECONDS:
            places = np.full(len(history), np.nan)
            known = seconds[: len(history)] if seconds is not None else places[:0]
            places[: len(known)] = known
            return places
        case _:
            assert_never(over)


def returns_figure(
    history: NDArray[np.float64],
    spec: TaskSpec | None,
    over: Over = Over.STEPS,
    seconds: NDArray[np.float64] | None = None,
    smoothing: int = SMOOTH_EPISODES,
    palette: Palette = DARK,
) -> go.Figure:
    """Return of each training episode, and its running mean.

    Args:
        history: [E, 4] as in `History`.
        spec: Adds the paper's score and the mark people call solved, where they are known.
        over: What the episodes stand over.
        seconds: [E] when each ended; only needed over seconds.
        smoothing: Episodes in the running mean; 1 leaves it out.
        palette: The colours of the page that it stands on.
    """
    figure = _frame(_AXES[over], "return", palette)
    steps, returns = places_on(over, history, seconds), history[:, 1]
    smooth = _running_mean(returns, smoothing)
    shown = _thin(len(steps))
    line = {"color": to_hex(palette.actions[0])}
    figure.add_scatter(
        x=steps[shown],
        y=returns[shown],
        name="each episode",
        mode="lines+markers" if len(steps) < 60 else "lines",
        line=dict(line, width=1),
        marker={"size": 3},
        opacity=0.45,
    )
    if smoothing > 1:
        figure.add_scatter(
            x=steps[shown],
            y=smooth[shown],
            name=f"mean of {smoothing}",
            mode="lines",
            line={"color": to_hex(palette.actions[1]), "width": 2.5},
        )
    if spec is not None:
        marks = (("solved", spec.entry.solved_at, "dash"), ("paper", spec.entry.paper_score, "dot"))
        known = [(word, level, dash) for word, level, dash in marks if level is not None]
        highest = max((level for _, level, _ in known), default=0.0)
        for word, level, dash in known:
            # Where two lines lie close, their words stand on either side of the pair.
            side = "top left" if level == highest else "bottom left"
            _mark(figure, level, word, dash, side, palette)
    return figure


def options_figure(
    history: NDArray[np.float64],
    over: Over = Over.STEPS,
    seconds: NDArray[np.float64] | None = None,
    palette: Palette = DARK,
) -> go.Figure:
    """Living options at the end of each training episode; see `returns_figure`."""
    figure = _frame(_AXES[over], "options", palette)
    shown = _thin(len(history))
    figure.add_scatter(
        x=places_on(over, history, seconds)[shown],
        y=history[shown, 3],
        name="options",
        mode="lines",
        line={"color": to_hex(palette.actions[2]), "width": 2.5},
        fill="tozeroy",
        fillcolor=_faint(palette.actions[2], 0.13),
    )
    figure.update_layout(showlegend=False)
    return figure


def margins_figure(margins: NDArray[np.float64]) -> go.Figure:
    """By how much the chosen action was expected to earn more, over the steps of an episode.

    Args:
        margins: [T] of the decisions.
    """
    figure = _frame("step", "margin", DARK)
    shown = _thin(len(margins))
    line = {"color": to_hex(DARK.actions[0]), "width": 1.8}
    figure.add_scatter(x=shown, y=margins[shown], name="margin", mode="lines", line=line)
    return figure


def weights_figure(
    weights: NDArray[np.float64],
    visits: NDArray[np.int64],
    spec: TaskSpec,
    palette: Palette = DARK,
) -> go.Figure:
    """What one option expects of each action; an action it never tried is left empty.

    Args:
        weights: [A] of the option.
        visits: [A] of the option.
        spec: Names the actions.
        palette: The colours of the page that it stands on.
    """
    figure = _frame("expected return", "", palette)
    is_ordered = spec.action_grid is not None
    colors = action_colors(spec.n_actions, is_ordered=is_ordered, palette=palette)
    tried = np.where(visits > 0, weights, np.nan)
    figure.add_bar(
        y=list(spec.action_names),
        x=tried,
        orientation="h",
        marker_color=[to_hex(c) for c in colors],
        text=["never tried" if n == 0 else f"{n} visits" for n in visits],
        textposition="auto",
        hovertemplate="%{y}: %{x:.2f}<extra></extra>",
    )
    figure.update_layout(showlegend=False)
    figure.update_yaxes(autorange="reversed")
    return figure


_AXES = {
    Over.STEPS: "steps",
    Over.EPISODES: "episodes",
    Over.SECONDS: "seconds of training, without pauses",
}


def style(figure: go.Figure, x: str, y: str, palette: Palette = DARK) -> None:
    """Gives every chart of a figure our letters, grid and axis titles."""
    grid = _faint(palette.chart, 0.22)
    figure.update_layout(
        template="none",
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={
            "family": "Segoe UI, Roboto, Helvetica, Arial, sans-serif",
            "size": 11,
            "color": to_hex(palette.chart),
        },
        margin={"l": 46, "r": 10, "t": 26, "b": 38},
        legend={
            "orientation": "h",
            "x": 0,
            "y": 1.02,
            "yanchor": "bottom",
            "bgcolor": "rgba(0,0,0,0)",
        },
        hovermode="x unified",
    )
    axis = {
        "gridcolor": grid,
        "zeroline": False,
        "linecolor": grid,
        "ticks": "",
        "automargin": True,
    }
    figure.update_xaxes(title={"text": x, "standoff": 6}, **axis)
    figure.update_yaxes(title={"text": y, "standoff": 4}, **axis)


def _frame(x: str, y: str, palette: Palette) -> go.Figure:
    figure = go.Figure()
    style(figure, x, y, palette)
    return figure


def _faint(rgb: Rgb, opacity: float) -> str:
    return f"rgba({rgb[0]},{rgb[1]},{rgb[2]},{opacity:g})"


def _mark(
    figure: go.Figure, level: float, word: str, dash: str, side: str, palette: Palette
) -> None:
    figure.add_hline(
        y=level,
        line={"color": to_hex(palette.chart), "width": 1.2, "dash": dash},
        annotation={
            "text": f"{word} {level:g}".replace("-", "−"),
            "font": {"size": 10, "color": to_hex(palette.chart)},
        },
        annotation_position=side,
    )


def _running_mean(values: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Mean of the latest `window` values at each position, of fewer at the beginning."""
    sums = np.cumsum(np.r_[0.0, values])
    ends = np.arange(1, len(values) + 1)
    starts = np.maximum(0, ends - window)
    return (sums[ends] - sums[starts]) / (ends - starts)


def _thin(count: int) -> NDArray[np.int64]:
    """Positions of at most MAX_POINTS of `count` points, first and last among them."""
    if count <= MAX_POINTS:
        return np.arange(count)
    return np.linspace(0, count - 1, MAX_POINTS).round().astype(np.int64)
