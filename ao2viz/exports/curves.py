"""What the charts show, as CSV: training episodes, the steps of one episode, one option."""

from typing import IO

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.exports.content import number_or_none
from ao2viz.exports.tables import write_rows
from ao2viz.recording.episode import Episode


def write_history_csv(
    history: NDArray[np.float64], seconds: NDArray[np.float64], stream: IO[bytes]
) -> None:
    """One row for each training episode, [E, 4] as in `History`; `seconds` [E] may be shorter."""
    known = np.full(len(history), np.nan)
    known[: len(seconds)] = seconds[: len(history)]
    head = (
        "episode",
        "steps until its end",
        "return",
        "length",
        "options",
        "seconds until then",
    )
    rows = (
        (number, int(end), total, int(length), int(options), number_or_none(float(second)))
        for number, ((end, total, length, options), second) in enumerate(
            zip(history.tolist(), known, strict=True), start=1
        )
    )
    write_rows(stream, head, rows)


def write_margins_csv(episode: Episode, spec: TaskSpec, stream: IO[bytes]) -> None:
    """One row for each step of an episode: what was done, the margin and the reward."""
    head = ("step", "action", "action name", "margin", "reward", "return so far", "explored")
    sums = np.cumsum(episode.rewards)
    rows = (
        (
            *(step, decision.action, spec.action_names[decision.action], decision.margin),
            *(float(episode.rewards[step]), float(sums[step]), int(decision.explored)),
        )
        for step, decision in enumerate(episode.decisions)
    )
    write_rows(stream, head, rows)


def write_weights_csv(option: int, view: ForestView, spec: TaskSpec, stream: IO[bytes]) -> None:
    """One row for each action of an option: its weight and how often it was tried."""
    rows = (
        (option, action, name, float(view.weights[option, action]), tried)
        for action, (name, tried) in enumerate(
            zip(spec.action_names, view.visits[option].tolist(), strict=True)
        )
    )
    write_rows(stream, ("option", "action", "action name", "expected return", "visits"), rows)
