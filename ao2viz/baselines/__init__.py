"""The algorithms that AO2 is compared with: PPO, PPOC, DAC+A2C, DAC+PPO, and others' own.

Needs the extra `baselines` (PyTorch and stable-baselines3), but only once one is made or loaded:

    agent = baselines.make("dac+ppo", "CartPole-v1", seed=0).learn(50_000)
    print(agent.evaluate(episodes=100).mean())
    agent.save("dac.safetensors")
"""

import os
from typing import TYPE_CHECKING, Any

import gymnasium as gym

from ao2viz.baselines.algorithm import Acting, Algorithm, to_algorithm
from ao2viz.extras import need

if TYPE_CHECKING:  # PyTorch is imported by who asks for an agent.
    from ao2viz.baselines.agent import OptionAgent
    from ao2viz.baselines.references import Reference

    Baseline = OptionAgent | Reference

__all__ = ["Acting", "Algorithm", "load", "make"]


_OURS = ("torch", "safetensors")
"""What our own algorithms need; stable-baselines3 takes seconds to import."""


def make(
    algorithm: Algorithm | str, env: str | gym.Env, seed: int = 0, **overrides: Any
) -> "Baseline":
    """An agent that has learned nothing yet.

    Args:
        algorithm: One of `Algorithm`, or its name such as "dac+ppo".
        env: A Gymnasium id, or an environment that `gymnasium.make` has made.
        seed: Everything random comes from it.
        overrides: Settings, on top of those proven for the environment; see `Settings`. The
            references (`sb3-ppo` and the like) take none.

    Raises:
        ValueError: If PyTorch is missing, the environment does not fit, or a setting is unknown or
            out of range.
    """
    chosen = to_algorithm(algorithm)
    _need_for(chosen)
    from ao2viz.baselines.making import Maker  # noqa: PLC0415

    if not chosen.is_reference:
        from ao2viz.baselines.agent import OptionAgent  # noqa: PLC0415  Optional.

        return OptionAgent(chosen, Maker(env), seed, overrides)
    if overrides:
        raise ValueError(
            f"{chosen.value} has the settings that its authors' zoo found, and takes none; got "
            f"{', '.join(overrides)}."
        )
    from ao2viz.baselines.references import Reference  # noqa: PLC0415  Optional.

    return Reference(chosen, Maker(env), seed)


def load(path: str | os.PathLike[str], env: str | gym.Env | None = None) -> "Baseline":
    """The agent that `save` wrote; it goes on learning with episodes of its own.

    Args:
        path: The .safetensors file.
        env: Its environment; made from the id in the file if not given.

    Raises:
        AgentFileError: If the file is none, broken, or from a newer ao2viz.
        ValueError: If PyTorch is missing, or `env` does not fit.
    """
    need("baselines", _OURS)
    from ao2viz.baselines.files import read  # noqa: PLC0415  Optional.
    from ao2viz.baselines.making import Maker  # noqa: PLC0415

    saved = read(path)
    _need_for(saved.algorithm)
    make = Maker(env or saved.spec.env_id, saved.spec)
    if not saved.algorithm.is_reference:
        from ao2viz.baselines.agent import OptionAgent  # noqa: PLC0415  Optional.

        return OptionAgent.from_saved(saved, make)
    from ao2viz.baselines.references import Reference  # noqa: PLC0415  Optional.

    return Reference.from_saved(saved, make)


def _need_for(algorithm: Algorithm) -> None:
    need("baselines", None if algorithm.is_reference else _OURS)
