"""The report's charts, as plotly figures: what `figures.line_chart` draws."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.statistics import Summary
from ao2viz.figures.drawing import Drawing
from ao2viz.figures.line_chart import draw_lines
from ao2viz.figures.palette import action_colors, to_hex
from ao2viz.paper.published import AO2_SCORE, TITLES, Learner

_SIZE = (1060.0, 380.0)
EPISODES_A_POINT = 5
"""Training episodes whose mean is one point of the training curve."""


def curves_drawing(env: str, curves: Sequence[tuple[Learner, Sequence[Summary]]]) -> Drawing:
    """Return over steps, one line a learner; steps on a logarithmic axis, as they differ widely."""
    colors = action_colors(len(TITLES), is_ordered=False)
    figure = go.Figure()
    for learner, along in curves:
        figure.add_scatter(
            x=[one.steps for one in along],
            y=[one.means.mean() for one in along],
            name=TITLES[learner],
            line={"color": to_hex(colors[list(TITLES).index(learner)]), "width": 2.2},
        )
    level = AO2_SCORE[env]
    figure.add_hline(level, annotation_text=f"the paper's AO2, average {level:g}")
    figure.update_layout(xaxis={"type": "log", "title": "steps of the environment"})
    return draw_lines(figure, f"{env}: mean return over steps", *_SIZE)


def training_drawing(seeds: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]) -> Drawing:
    """Return of training episodes over steps: a thin line a seed, a thick one for their mean.

    Args:
        seeds: For each, [P] steps and [P] mean returns, the steps the same for all.
    """
    gray, blue = "#8b95a5", to_hex(action_colors(2, is_ordered=False)[0])
    figure = go.Figure()
    for steps, returns in seeds:
        figure.add_scatter(
            x=steps, y=returns, name="a seed", opacity=0.5, line={"color": gray, "width": 1}
        )
    mean = np.mean([returns for _, returns in seeds], axis=0)
    figure.add_scatter(x=seeds[0][0], y=mean, name="mean", line={"color": blue, "width": 2.5})
    figure.update_layout(xaxis={"title": "steps of the environment"})
    return draw_lines(figure, "Return of training episodes over steps", *_SIZE)


def training_points(
    evaluations: Sequence[Evaluation],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Steps and mean returns of one run's training episodes, a few at a time."""
    ordered = sorted(evaluations, key=lambda one: one.steps)
    ends = [end for one in ordered for end in one.episode_ends]
    earned = [value for one in ordered for value in one.episode_returns]
    whole = len(ends) // EPISODES_A_POINT * EPISODES_A_POINT
    steps = np.array(ends[:whole], np.float64).reshape(-1, EPISODES_A_POINT)
    returns = np.array(earned[:whole], np.float64).reshape(-1, EPISODES_A_POINT)
    return steps[:, -1], returns.mean(axis=1)
