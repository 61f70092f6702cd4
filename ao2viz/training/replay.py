"""A recorded episode played again from its seed and actions, to see what it looked like."""

from collections.abc import Iterator

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.motion import Motion
from ao2viz.envs.task import TaskSpec, make_env
from ao2viz.recording.episode import Episode
from ao2viz.training.branching import check_repeats
from ao2viz.training.loop import reset, step


def replay_pictures(
    episode: Episode, spec: TaskSpec, env_id: str | None = None
) -> Iterator[NDArray[np.uint8]]:
    """Yields [height, width, 3] before every step and after the last.

    Args:
        episode: As recorded.
        spec: Its task.
        env_id: How to make the environment, where the episode's id is not enough.

    Raises:
        ValueError: If the environment cannot be made or drawn, or does not repeat the recording.
    """
    env = make_env(env_id or episode.env_id, render=True)
    try:
        if env.render_mode != "rgb_array":
            raise ValueError(f"{episode.env_id} cannot draw itself.")
        for _ in _replay(env, episode, spec):
            yield np.asarray(env.render())
    finally:
        env.close()


def _replay(env: gym.Env, episode: Episode, spec: TaskSpec) -> Iterator[None]:
    """Stops before every step and after the last; fails where the recording is not repeated."""
    motion = Motion(spec, episode.action_smoothing)
    observation = reset(env, spec, episode.seed)
    for t in range(len(episode) + 1):
        if t > 0:
            observation = step(env, spec, motion, int(episode.actions[t - 1]))[0]
        check_repeats(episode, t, observation)
        yield
