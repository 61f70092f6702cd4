"""Learning again: the same agent from the same seed, watched, or without one of its episodes."""

from collections.abc import Callable, Mapping

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ao2viz.core.agent import make_learner
from ao2viz.core.config import Config
from ao2viz.core.learner import Learner
from ao2viz.envs.task import TaskSpec
from ao2viz.recording.history import History
from ao2viz.training.loop import Stepper, training_seed

Progress = Callable[[float], bool | None]
"""Called with the share that is done; returning False ends it."""

# Steps between two calls of a progress.
_STEPS_AT_A_TIME = 200


class LearningStoppedError(Exception):
    """Learning again was called off."""


def learn_again(
    env: gym.Env,
    spec: TaskSpec,
    config: Config,
    seed: int,
    n_steps: int,
    *,
    watch: Callable[[Learner], None] | None = None,
    without: int | None = None,
    expected: NDArray[np.float64] | None = None,
    on_progress: Progress | None = None,
) -> Learner:
    """Takes so many steps from a fresh start, as `AO2.learn` does, and lets it settle.

    Args:
        env: Its environment.
        spec: The environment as the agent sees it.
        config: Its settings.
        seed: Its seed.
        n_steps: Steps of the environment.
        watch: Gets the learner before it begins.
        without: The training episode, counted from 0, of which nothing is learned. It is played
            as it was; when it ends, forest, experience and step count go back to where they were
            when it began. The chance draws go on.
        expected: The training history [E, 4] that this has to follow.
        on_progress: Told how far it is.

    Raises:
        ValueError: If what happens is not what is expected.
        LearningStoppedError: If `on_progress` ended it.
    """
    rng = np.random.default_rng(seed)
    learner = make_learner(config, spec.ranges, spec.n_actions, rng)
    if watch is not None:
        watch(learner)
    history = History()
    stepper = Stepper(env, spec, learner, lambda: training_seed(rng), learns=True, history=history)
    before: Mapping[str, NDArray] | None = None
    for n in range(n_steps):
        if without is not None and len(history) == without and before is None:
            before = learner.get_state()
        result = stepper.step()
        if result.has_ended:
            if before is not None and len(history) == (without or 0) + 1:
                learner.set_state(dict(before))
            if expected is not None:
                _check(history, expected)
        if on_progress is not None and n % _STEPS_AT_A_TIME == 0:
            _report(on_progress, n / n_steps)
    if without is not None and len(history) == without and before is not None:
        learner.set_state(dict(before))  # The last one, cut short.
    learner.sleep()
    return learner


def _report(on_progress: Progress, share: float) -> None:
    if on_progress(share) is False:
        raise LearningStoppedError("Learning again was called off.")


def _check(history: History, expected: NDArray[np.float64]) -> None:
    """Compares the latest episode with the one that there was."""
    n = len(history) - 1
    if n < len(expected) and not np.array_equal(history.to_array()[n], expected[n]):
        raise ValueError(_differs(f"training episode {n} went otherwise"))


def check_same(learner: Learner, state: Mapping[str, NDArray]) -> None:
    """Makes sure that what was learned again is what the agent knows, to the bit.

    Raises:
        ValueError: If it is not.
    """
    again = learner.get_state()
    for name in state:
        if name not in again or not np.array_equal(again[name], state[name], equal_nan=True):
            raise ValueError(_differs(f"{name!r} came out otherwise"))


def _differs(what: str) -> str:
    return (
        f"This agent cannot be learned again exactly: {what}. That is so if it was taught in "
        f"several parts, if a setting was changed on the way, or if its environment is not what it "
        f"was."
    )
