"""A task in a file: what an agent must know of its environment, as plain JSON."""

import math
from typing import Any

import numpy as np

from ao2viz.envs.catalogue import CATALOGUE, Entry, Feature
from ao2viz.envs.task import MAX_ACTION_BINS, MAX_ACTIONS, TaskSpec
from ao2viz.store.errors import AgentFileError, quote
from ao2viz.store.fields import Fields, Json

MAX_FEATURES = 10_000


def task_to_json(spec: TaskSpec) -> Json:
    """The task, ready for JSON."""
    return {
        "env_id": spec.env_id,
        "title": spec.title,
        "features": [
            {"name": f.name, "unit": f.unit, "scale": f.scale, "range": float(width)}
            for f, width in zip(spec.features, spec.ranges, strict=True)
        ],
        "action_names": list(spec.action_names),
        "action_grid": None if spec.action_grid is None else spec.action_grid.tolist(),
        "action_offset": spec.action_offset,
        "action_bins": spec.action_bins,
    }


def task_from_json(task: Fields) -> TaskSpec:
    """The task that `task_to_json` wrote; needs no environment.

    Raises:
        AgentFileError: Naming the first field that is not as it should be.
    """
    env_id, title = task.text("env_id"), task.text("title")
    if ":" in env_id:  # Gymnasium would import what stands before the colon.
        raise AgentFileError(f"Expected an environment's plain id, but got {quote(env_id)}.")
    features, ranges = [], []
    for i, raw in enumerate(task.items("features", MAX_FEATURES)):
        one = Fields(raw, f"feature {i}")
        ranges.append(one.number("range"))
        features.append(
            Feature(one.text("name"), one.text("unit"), one.number("scale"), ranges[-1])
        )
    names = tuple(
        task.check_text("action_names", n) for n in task.items("action_names", MAX_ACTIONS)
    )
    if not (features and names and min(ranges) > 0 and all(f.scale for f in features)):
        raise AgentFileError(
            "Expected at least one feature and one action, scales other than 0 and positive ranges."
        )
    grid, bins = None, task.raw("action_bins")
    if task.raw("action_grid") is not None:
        grid = _grid(task.items("action_grid", MAX_ACTIONS), len(names))
        bins = task.whole("action_bins", 2, MAX_ACTION_BINS)
    elif bins is not None:
        raise AgentFileError("Expected no action_bins where actions are discrete.")
    entry = CATALOGUE.get(env_id, Entry(env_id, title))
    return TaskSpec(
        env_id=env_id,
        title=title,
        features=tuple(features),
        action_names=names,
        ranges=np.array(ranges, np.float64),
        action_grid=grid,
        action_offset=task.whole("action_offset", -(2**31), 2**31),
        action_bins=bins,
        entry=entry,
    )


def _grid(rows: list[Any], n_actions: int) -> np.ndarray:
    dims = len(rows[0]) if rows and isinstance(rows[0], list) else 0
    sound = len(rows) == n_actions and all(
        isinstance(row, list)
        and len(row) == dims
        and all(type(x) in (int, float) and math.isfinite(x) and abs(x) < 1e300 for x in row)
        for row in rows
    )
    if not sound or not 1 <= dims <= 3:
        raise AgentFileError("Expected action_grid to hold one to three finite numbers an action.")
    return np.array(rows, np.float64)
