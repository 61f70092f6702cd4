"""Episodes played side by side, for evaluation: nothing is learned."""

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.task import TaskSpec, to_observation

_WIDTH = 50  # Episodes at a time.

# Observations [n, D], what it returned before, for these rows, and whether episodes begin: what
# `env.step` wants for each row, and what it wants to be given next time, one entry a row.
Act = Callable[[NDArray[np.float64], NDArray, NDArray[np.bool_]], tuple[Sequence[Any], NDArray]]


def play_together(
    make: Callable[[], gym.Env], spec: TaskSpec, act: Act, seeds: Sequence[int]
) -> NDArray[np.float64]:
    """The return of an episode from each seed, whichever others are played beside it."""
    envs = [make() for _ in range(min(_WIDTH, len(seeds)))]
    try:
        chunks = [seeds[i : i + _WIDTH] for i in range(0, len(seeds), _WIDTH)]
        return np.concatenate([_play(envs, spec, act, chunk) for chunk in chunks])
    finally:
        for env in envs:
            env.close()


def _play(
    envs: Sequence[gym.Env], spec: TaskSpec, act: Act, seeds: Sequence[int]
) -> NDArray[np.float64]:
    seen = np.stack(
        [
            to_observation(env.reset(seed=seed)[0], spec)
            for env, seed in zip(envs, seeds, strict=False)
        ]
    )
    totals = np.zeros(len(seeds))
    state: NDArray = np.zeros(len(seeds), np.int64)
    begins = np.ones(len(seeds), np.bool_)
    running = np.arange(len(seeds))
    while len(running):
        actions, kept = act(seen[running], state[running], begins[running])
        state[running] = kept
        begins[running] = False
        goes_on = np.ones(len(running), np.bool_)
        for at, (i, action) in enumerate(zip(running.tolist(), actions, strict=True)):
            raw, reward, terminated, truncated, _ = envs[i].step(action)
            seen[i] = to_observation(raw, spec)
            totals[i] += float(reward)
            goes_on[at] = not (terminated or truncated)
        running = running[goes_on]
    return totals
