"""The settings of the references, as rl-baselines3-zoo found them (MIT); needs none of them.

Less what changes over a run, the learning rate and clipping on CartPole: how long a run will be is
not known here.
"""

import copy
from collections.abc import Mapping
from typing import Any

from ao2viz.baselines.algorithm import Algorithm
from ao2viz.baselines.settings import make_settings

_BESIDE = {"envs": 1, "normalise": False}  # What is ours to do, around the algorithm.

_CARTPOLE_PPO = {
    "envs": 8, "n_steps": 32, "batch_size": 256, "gae_lambda": 0.8, "gamma": 0.98, "n_epochs": 20,
    "learning_rate": 1e-3,
}  # fmt: skip
_CARTPOLE_QRDQN = {
    "learning_rate": 2.3e-3, "batch_size": 64, "buffer_size": 100_000, "learning_starts": 1000,
    "target_update_interval": 10, "train_freq": 256, "gradient_steps": 128,
    "exploration_fraction": 0.16, "exploration_final_eps": 0.04,
    "policy_kwargs": {"net_arch": [256, 256], "n_quantiles": 10},
}  # fmt: skip
_PROVEN: Mapping[tuple[Algorithm, str], Mapping[str, Any]] = {
    (Algorithm.SB3_PPO, "CartPole-v0"): _CARTPOLE_PPO,
    (Algorithm.SB3_PPO, "CartPole-v1"): _CARTPOLE_PPO,
    (Algorithm.SB3_PPO, "Acrobot-v1"): {
        "envs": 16, "normalise": True, "n_steps": 256, "gae_lambda": 0.94, "gamma": 0.99,
        "n_epochs": 4, "ent_coef": 0.0,
    },
    (Algorithm.SB3_PPO, "Pendulum-v1"): {
        "envs": 4, "n_steps": 1024, "gae_lambda": 0.95, "gamma": 0.9, "n_epochs": 10,
        "ent_coef": 0.0, "learning_rate": 1e-3, "use_sde": True, "sde_sample_freq": 4,
    },
    (Algorithm.SB3_SAC, "Pendulum-v1"): {"learning_rate": 1e-3},
    (Algorithm.SB3_QRDQN, "CartPole-v0"): _CARTPOLE_QRDQN,
    (Algorithm.SB3_QRDQN, "CartPole-v1"): _CARTPOLE_QRDQN,
    (Algorithm.SB3_QRDQN, "Acrobot-v1"): {
        "learning_rate": 6.3e-4, "batch_size": 128, "buffer_size": 50_000, "learning_starts": 0,
        "target_update_interval": 250, "train_freq": 4, "gradient_steps": 4,
        "exploration_fraction": 0.12, "exploration_final_eps": 0.1,
        "policy_kwargs": {"net_arch": [256, 256], "n_quantiles": 25},
    },
}  # fmt: skip
# Steps between updates where the settings do not say; the libraries' own.
_STEPS = {Algorithm.SB3_PPO: 2048, Algorithm.SB3_SAC: 1, Algorithm.SB3_QRDQN: 4}


def reference_settings(algorithm: Algorithm, env_id: str) -> dict[str, Any]:
    """What a reference is made with: `envs` and `normalise`, and what its class takes."""
    return copy.deepcopy({**_BESIDE, **_PROVEN.get((algorithm, env_id), {})})


def steps_per_update(algorithm: Algorithm, env_id: str) -> int:
    """Environment steps between two updates: `learn` stops, and is evaluated, at multiples."""
    if not algorithm.is_reference:
        return make_settings(algorithm, env_id, {}).steps_per_update
    settings = reference_settings(algorithm, env_id)
    steps = settings.get("n_steps") or settings.get("train_freq") or _STEPS[algorithm]
    return steps * settings["envs"]
