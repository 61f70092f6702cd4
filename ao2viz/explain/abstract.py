"""What an agent is, in a few lines: for the head of every page that shows one."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config, preset_of
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import count, number

_RECENT = 100  # Training episodes.


def summarise(
    spec: TaskSpec,
    config: Config,
    seed: int,
    n_steps: int,
    view: ForestView,
    history: NDArray[np.float64],
) -> list[tuple[str, str]]:
    """Pairs of a word and a value; plain text. `history` [E, 4] is as in `History`."""
    roots = int(((view.parents == NO_OPTION) & view.is_alive).sum())
    rows = [
        ("environment", f"{spec.title} ({spec.env_id})"),
        ("preset", preset_of(config).value),
        ("decides by", config.decide_by.value),
        ("learned from", f"{count(n_steps, 'step')}, seed {seed}"),
        ("forest", f"{count(len(view), 'option')} in {count(roots, 'schema')}"),
    ]
    if len(history):
        recent = history[-_RECENT:, 1]
        mean = number(float(recent.mean()), 4)
        last = f"the mean of the last {count(len(recent), 'episode')}, exploration included"
        rows.append(("training return", f"{mean}, {last}"))
    return rows
