"""What was learned after how many steps, over several seeds: one chart for each environment."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from ao2viz.baselines.algorithm import Acting
from ao2viz.core.decision import DecideBy
from ao2viz.figures.bands import band
from ao2viz.figures.charts import style
from ao2viz.figures.palette import Rgb, action_colors, to_hex

_CHART_PX = 380  # Height of one environment's chart.
_DASHES: Mapping[DecideBy | Acting, str] = {
    DecideBy.VOTE: "solid",
    DecideBy.PATH: "dash",
    Acting.GREEDY: "solid",
    Acting.SAMPLED: "dot",
}
_WAYS: Mapping[DecideBy | Acting, str] = {
    DecideBy.VOTE: "by vote",
    DecideBy.PATH: "by one path",
    Acting.GREEDY: "greedy",
    Acting.SAMPLED: "drawn",
}
_SEED_OPACITY = 0.35


@dataclass(frozen=True, eq=False)
class Curve:
    """How one group of seeds learned; `C` counts checkpoints.

    A seed's array holds NaN where it was not evaluated.
    """

    env: str
    group: str  # Preset and settings in words; equal ones share a colour.
    decide_by: DecideBy | Acting
    steps: NDArray[np.int64]  # [C] rising.
    middle: NDArray[np.float64]  # [C] interquartile mean of the seeds' mean returns.
    low: NDArray[np.float64]  # [C] lower end of its interval; `middle` for a single seed.
    high: NDArray[np.float64]  # [C] upper end.
    seeds: dict[int, NDArray[np.float64]]  # [C] mean return of each seed.


def say_way(way: DecideBy | Acting) -> str:
    """How it was decided, in words that go behind a return."""
    return _WAYS[way]


def learning_curves_figure(curves: Sequence[Curve]) -> go.Figure:
    """Return over steps: a line with its band for each curve, and a thin line for each seed.

    Colours tell presets and settings apart, dashes the ways of deciding.

    Raises:
        ValueError: If there is no curve.
    """
    if not curves:
        raise ValueError("Expected at least one learning curve, but there are none.")
    envs = list(dict.fromkeys(curve.env for curve in curves))
    groups = list(dict.fromkeys(curve.group for curve in curves))
    colors = action_colors(len(groups), is_ordered=False)
    spacing = 0.3 / len(envs)
    figure = make_subplots(rows=len(envs), cols=1, subplot_titles=envs, vertical_spacing=spacing)
    shown: set[str] = set()
    layers: list[list[tuple[go.Scatter, int]]] = [[], [], []]  # No band may veil a line.
    for curve in curves:
        row = envs.index(curve.env) + 1
        r, g, b = (int(part) for part in colors[groups.index(curve.group)])
        name = f"{curve.group}, {say_way(curve.decide_by)}"
        band, *seeds, middle = _traces(curve, name, (r, g, b), in_legend=name not in shown)
        for layer, traces in zip(layers, ([band], seeds, [middle]), strict=True):
            layer += [(trace, row) for trace in traces]
        shown.add(name)
    for trace, row in itertools.chain(*layers):
        figure.add_trace(trace, row=row, col=1)
    style(figure, "steps of the environment", "mean return (sum of rewards)")
    # On a page of its own it has room for a legend, and a background to be read on.
    figure.update_layout(
        height=_CHART_PX * len(envs) + 120,
        margin={"l": 70, "r": 20, "t": 90, "b": 60},
        legend={"y": 1 + 50 / (_CHART_PX * len(envs))},
        paper_bgcolor="white",
        plot_bgcolor="white",
        font={"size": 13, "color": "#3a4250"},
        hovermode="closest",
    )
    return figure


def _traces(curve: Curve, name: str, color: Rgb, *, in_legend: bool) -> list[go.Scatter]:
    dash = _DASHES[curve.decide_by]
    line = {"color": to_hex(color), "dash": dash}
    common = {"legendgroup": name, "name": name}
    seeds = [
        go.Scatter(
            x=curve.steps,
            y=returns,
            mode="lines+markers",
            line=dict(line, width=1),
            marker={"size": 3},
            opacity=_SEED_OPACITY,
            connectgaps=True,
            showlegend=False,
            hovertemplate=f"seed {seed}: %{{y:.1f}} after %{{x:,}} steps<extra></extra>",
            **common,
        )
        for seed, returns in curve.seeds.items()
    ]
    middle = go.Scatter(
        x=curve.steps,
        y=curve.middle,
        mode="lines+markers",
        line=dict(line, width=2.5),
        marker={"size": 6},
        showlegend=in_legend,
        customdata=np.column_stack([curve.low, curve.high]),
        hovertemplate=(
            "IQM %{y:.1f} [%{customdata[0]:.1f}, %{customdata[1]:.1f}] after %{x:,} steps"
            "<extra>%{fullData.name}</extra>"
        ),
        **common,
    )
    around = band(curve.steps, curve.low, curve.high, color, **common)
    return [around, *seeds, middle]
