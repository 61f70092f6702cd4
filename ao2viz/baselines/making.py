"""As many environments of one kind as an algorithm steps side by side."""

from functools import partial

import gymnasium as gym

from ao2viz.envs.matching import check_env, check_match
from ao2viz.envs.task import TaskSpec, describe, make_env


class Maker:
    """Makes environments that are all alike; called without arguments."""

    def __init__(self, env: str | gym.Env, spec: TaskSpec | None = None) -> None:
        """Finds out how to make more.

        Args:
            env: A Gymnasium id ("module:EnvId" imports the module first), or an environment that
                `gymnasium.make` has made.
            spec: What they are to be like; None: what this environment is like.

        Raises:
            ValueError: If it is none, cannot be made twice, does not fit, or is not like `spec`.
        """
        if isinstance(env, str):
            self._make = partial(make_env, env)
        else:
            registered = check_env(env).spec
            if registered is None:
                raise ValueError(
                    "Expected an environment made by gymnasium.make, as several of the same kind "
                    "are stepped side by side. Register yours, and give its id."
                )
            self._make = partial(gym.make, registered)
        one = self._make()
        self.spec = describe(one) if spec is None else spec
        if spec is not None:
            check_match(one, spec)
        one.close()

    def __call__(self) -> gym.Env:
        """One more."""
        return self._make()
