"""Whether what somebody gives an agent is an environment, and one that it can act in."""

from typing import Any

import gymnasium as gym

from ao2viz.envs.task import TaskSpec, describe


def check_env(env: Any) -> gym.Env:
    """The environment as it is.

    Raises:
        ValueError: If it is something else, or many in one.
    """
    if not isinstance(env, gym.Env):
        raise ValueError(
            f"Expected a Gymnasium id or a single gymnasium.Env, but got {type(env).__name__}."
        )
    return env


def check_match(env: gym.Env, spec: TaskSpec) -> gym.Env:
    """The environment as it is, if an agent made for `spec` can act in it.

    Raises:
        ValueError: If it cannot; says what both have.
    """
    came = describe(env, spec.action_bins)
    expected, got = (
        (
            task.n_features,
            task.n_actions,
            task.action_offset,
            None if task.action_grid is None else task.action_grid.tolist(),
        )
        for task in (spec, came)
    )
    if got != expected:
        raise ValueError(
            f"This agent learned on {spec.env_id}, with {spec.n_features} features and the "
            f"actions {', '.join(spec.action_names)}; {came.env_id} has {came.n_features} "
            f"features and the actions {', '.join(came.action_names)}. Give it its own "
            f"environment."
        )
    return env
