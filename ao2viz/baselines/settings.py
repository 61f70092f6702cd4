"""The settings of the compared algorithms: one frozen record, checked once, and what is proven."""

import dataclasses
import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ao2viz.baselines.algorithm import Algorithm


@dataclass(frozen=True)
class Settings:
    """Every number that PPO, PPOC, DAC+A2C and DAC+PPO have."""

    envs: int = 8  # Environments that are stepped side by side.
    rollout: int = 128  # Steps of each between two updates.
    epochs: int = 5  # How often an update goes through a rollout; DAC+A2C: once.
    minibatch: int = 256  # Steps in one gradient step; DAC+A2C: the whole rollout.
    learning_rate: float = 1e-3
    gamma: float = 0.99  # Discount.
    trace: float = 0.95  # λ of the generalised advantage estimates.
    clip: float = 0.2  # PPO's ε.
    entropy: float = 0.01  # Of the policy over options; the options' own get none.
    margin: float = 0.01  # PPOC: how much better another option must be to end one.
    options: int = 4  # K; PPO has 1.
    hidden: int = 64  # Units in each of two layers.
    max_gradient: float = 0.5  # The gradient's norm is cut to this.
    normalise: bool = False  # Observations and rewards by running statistics.

    @property
    def steps_per_update(self) -> int:
        """Environment steps between two updates; training ends after a multiple of it."""
        return self.envs * self.rollout


# Least and greatest; a file cannot ask for more memory than these allow.
_RANGES: Mapping[str, tuple[float, float]] = {
    "envs": (1, 256), "rollout": (1, 100_000), "epochs": (1, 1000), "minibatch": (1, 1_000_000),
    "learning_rate": (1e-8, 1.0), "gamma": (0.0, 1.0), "trace": (0.0, 1.0), "clip": (1e-6, 10.0),
    "entropy": (0.0, 10.0), "margin": (0.0, 1000.0), "options": (1, 64), "hidden": (1, 1024),
    "max_gradient": (1e-6, 1e6),
}  # fmt: skip

_CARTPOLE = {"gamma": 0.98, "trace": 0.9}
_PROVEN: Mapping[str, Mapping[str, Any]] = {
    "CartPole-v0": _CARTPOLE,
    "CartPole-v1": _CARTPOLE,
    "Acrobot-v1": {"envs": 16, "epochs": 4, "trace": 0.94, "normalise": True},
    "Pendulum-v1": {
        "envs": 16, "epochs": 10, "minibatch": 128, "gamma": 0.9, "learning_rate": 5e-4,
    },
}  # fmt: skip
_PROVEN_FOR: Mapping[tuple[Algorithm, str], Mapping[str, Any]] = {
    # At 1e-3 it collapsed after it had learned.
    (Algorithm.PPOC, "CartPole-v0"): {"learning_rate": 3e-4},
    (Algorithm.PPOC, "CartPole-v1"): {"learning_rate": 3e-4},
    (Algorithm.PPOC, "Pendulum-v1"): {"normalise": True},
    # It uses each step but once, and learned nothing from fewer, larger updates.
    (Algorithm.DAC_A2C, "Pendulum-v1"): {
        "envs": 4,
        "rollout": 8,
        "learning_rate": 1e-3,
        "max_gradient": 5.0,
        "normalise": True,
    },
}
_ALWAYS: Mapping[Algorithm, Mapping[str, Any]] = {
    Algorithm.PPO: {"options": 1},
    # Advantage actor-critics learn from many short rollouts, as each is used but once.
    Algorithm.DAC_A2C: {"rollout": 16},
}


def make_settings(algorithm: Algorithm, env_id: str, overrides: Mapping[str, Any]) -> Settings:
    """The proven settings of an algorithm for an environment, with changes.

    Raises:
        ValueError: If a setting is unknown or out of range; names it.
    """
    known = {field.name: field.type for field in dataclasses.fields(Settings)}
    for name in overrides:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f" Did you mean {near[0]}?" if near else f" There are {', '.join(known)}."
            raise ValueError(f"There is no setting {name!r} in {algorithm.value}.{hint}")
    proven = {
        **_PROVEN.get(env_id, {}),
        **_ALWAYS.get(algorithm, {}),
        **_PROVEN_FOR.get((algorithm, env_id), {}),
    }
    chosen = {**proven, **overrides}
    for name, value in chosen.items():
        _check(name, value, known[name])
    typed: dict[str, Any] = {
        name: float(value) if known[name] is float else value for name, value in chosen.items()
    }
    settings = Settings(**typed)
    if algorithm is Algorithm.PPO and settings.options != 1:
        raise ValueError(f"PPO has one policy: options is 1, but got {settings.options}.")
    return settings


def _check(name: str, value: Any, kind: Any) -> None:
    if kind is bool:
        if not isinstance(value, bool):
            raise ValueError(f"Expected true or false for {name}, but got {value!r}.")
        return
    least, most = _RANGES[name]
    sound = not isinstance(value, bool) and isinstance(value, int if kind is int else (int, float))
    if not sound or not math.isfinite(value) or not least <= value <= most:
        word = "a whole number" if kind is int else "a number"
        raise ValueError(f"Expected {word} from {least:g} to {most:g} for {name}, not {value!r}.")
