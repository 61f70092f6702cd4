"""The report's charts."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.statistics import Summary
from ao2viz.figures.comparisons import Level, Line, lines_drawing
from ao2viz.figures.drawing import Drawing
from ao2viz.figures.palette import action_colors, to_hex
from ao2viz.paper.published import AO2_SCORE, TITLES, Learner

EPISODES_A_POINT = 5
"""Training episodes whose mean is one point of the training curve."""

_ACROSS = "steps of the environment"
_GRAY = "#8b95a5"


def curves_drawing(env: str, curves: Sequence[tuple[Learner, Sequence[Summary]]]) -> Drawing:
    """Return over steps, one line a learner; steps on a logarithmic axis, as they differ widely."""
    colors = action_colors(len(TITLES), is_ordered=False)
    lines = [
        Line(
            TITLES[learner],
            np.array([one.steps for one in along]),
            np.array([one.means.mean() for one in along]),
            to_hex(colors[list(TITLES).index(learner)]),
        )
        for learner, along in curves
    ]
    score = AO2_SCORE[env]
    level = Level(score, f"the paper's AO2, average {score:g}".replace("-", "−"))
    return lines_drawing(f"{env}: mean return over steps", _ACROSS, lines, level, is_log=True)


def training_drawing(seeds: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]) -> Drawing:
    """Return of training episodes over steps: a thin line a seed, a thick one for their mean.

    Args:
        seeds: For each, [P] steps and [P] mean returns, the steps the same for all.
    """
    lines = [Line("", steps, returns, _GRAY, 1.0, 0.5) for steps, returns in seeds]
    mean = np.mean([returns for _, returns in seeds], axis=0)
    blue = to_hex(action_colors(2, is_ordered=False)[0])
    lines.append(Line("mean of the seeds", seeds[0][0], mean, blue))
    title = "Return of training episodes over steps"
    return lines_drawing(title, _ACROSS, lines, is_log=False)


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
