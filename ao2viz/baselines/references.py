"""Others' own implementations behind our face: what stable-baselines3 and sb3-contrib learn.

Nothing of them is pickled: networks are kept as plain numbers.
"""

import copy
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import gymnasium as gym
import numpy as np
import torch
from numpy.typing import NDArray
from sb3_contrib import QRDQN
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from ao2viz.baselines.algorithm import Algorithm
from ao2viz.baselines.files import SavedBaseline, take, to_history, write
from ao2viz.baselines.making import Maker
from ao2viz.baselines.playing import play_together
from ao2viz.baselines.threads import one_thread
from ao2viz.baselines.zoo import reference_settings, steps_per_update
from ao2viz.envs.task import TaskSpec, to_observation
from ao2viz.recording.history import EpisodeSummary, History
from ao2viz.store.errors import AgentFileError
from ao2viz.training.loop import evaluation_seed, to_seed
from ao2viz.training.progress import advancing

_CLASSES: Mapping[Algorithm, type[BaseAlgorithm]] = {
    Algorithm.SB3_PPO: PPO,
    Algorithm.SB3_SAC: SAC,
    Algorithm.SB3_QRDQN: QRDQN,
}


class Reference:
    """An agent that others' code learns for; see `baselines.make`.

    While it learns it draws from the global generators of PyTorch and NumPy, seeded when it is
    made: agents that learn in turns disturb each other. Computes on one thread.
    """

    def __init__(self, algorithm: Algorithm, make: Maker, seed: int) -> None:
        self.algorithm = algorithm
        self.spec: TaskSpec = make.spec
        self.seed = to_seed(seed)
        self.history = History()
        self.settings = reference_settings(algorithm, self.spec.env_id)
        self._make = make
        _check_actions(algorithm, self.spec)
        given = copy.deepcopy(self.settings)  # The library adds to what it is given.
        n_envs, normalise = given.pop("envs"), given.pop("normalise")
        vectorised = DummyVecEnv([lambda: Monitor(make())] * n_envs)
        self._normaliser = (
            VecNormalize(vectorised, gamma=given.get("gamma", 0.99)) if normalise else None
        )
        self._model: Any = _CLASSES[algorithm](
            "MlpPolicy",
            self._normaliser or vectorised,
            seed=self.seed % 2**32,
            device="cpu",
            **given,
        )
        self._n_steps = 0
        self._can_learn = True

    @property
    def num_timesteps(self) -> int:
        """Environment steps learned from so far."""
        return self._n_steps

    @property
    def n_parameters(self) -> int:
        """Numbers that are learned, copies that only follow others not counted."""
        return sum(
            one.numel()
            for name, one in self._model.policy.named_parameters()
            if not name.split(".")[0].endswith("_target")
        )

    @property
    def steps_per_update(self) -> int:
        """`learn` stops at multiples of it."""
        return steps_per_update(self.algorithm, self.spec.env_id)

    @property
    def env(self) -> gym.Env:
        """One more of its environments; a new one at every call."""
        return self._make()

    def learn(
        self,
        total_timesteps: int,
        callback: Callable[["Reference"], bool | None] | None = None,
        progress_bar: bool = False,
    ) -> Self:
        """Learns for so many more environment steps; see `OptionAgent.learn`.

        What falls over a run, such as QR-DQN's exploration, falls over this call.

        Raises:
            ValueError: If it was loaded: what learning needs beside the networks is not kept.
        """
        if not self._can_learn:
            raise ValueError(
                f"A loaded {self.algorithm.value} plays and is evaluated, but cannot go on "
                f"learning: its optimiser and memory are not in the file. Make a new one."
            )
        with one_thread(), advancing(total_timesteps, is_shown=progress_bar) as advance:
            listener = _Listener(self, callback, advance)
            self._model.learn(total_timesteps, listener, reset_num_timesteps=False)
            listener.tell()
        return self

    def predict(
        self,
        observation: NDArray,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Actions in the environment's own terms; there is no state. See `OptionAgent.predict`."""
        del episode_start
        is_batch = np.ndim(observation) == 2
        rows = observation if is_batch else [observation]
        seen = np.stack([to_observation(row, self.spec) for row in rows])
        with one_thread():
            actions = self._act(seen, deterministic)
        return (np.array(actions) if is_batch else actions[0]), state

    def evaluate(
        self, episodes: int = 100, seed: int = 0, deterministic: bool = True
    ) -> NDArray[np.float64]:
        """The return of each of so many episodes; see `OptionAgent.evaluate`."""

        def act(
            seen: NDArray[np.float64], kept: NDArray, begins: NDArray[np.bool_]
        ) -> tuple[Sequence[Any], NDArray]:
            del begins
            return self._act(seen, deterministic), kept

        seeds = [evaluation_seed(seed, i) for i in range(episodes)]
        with one_thread(), torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            return play_together(self._make, self.spec, act, seeds)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes what is needed to play to one .safetensors file.

        Raises:
            ValueError: If the name ends otherwise.
            OSError: If the file cannot be written.
        """
        tensors = {name: array.copy() for name, array in self._tensors().items()}
        tensors["history"] = self.history.to_array()
        write(
            path,
            SavedBaseline(
                self.algorithm, self.spec, self.settings, self.seed, self._n_steps, tensors
            ),
        )

    @classmethod
    def from_saved(cls, saved: SavedBaseline, make: Maker) -> Self:
        """The agent of a file that was read; see `baselines.load`.

        Raises:
            AgentFileError: If settings or numbers do not fit.
        """
        try:
            agent = cls(saved.algorithm, make, saved.seed)
        except ValueError as error:
            raise AgentFileError(f"The task does not fit: {error}") from error
        if dict(saved.settings) != agent.settings:
            raise AgentFileError(
                f"Expected the settings {agent.settings}, as only those are known here."
            )
        expected = agent._tensors()
        if unknown := sorted(saved.tensors.keys() - expected.keys() - {"history"}):
            raise AgentFileError(f"Expected no tensor called {unknown[0]!r}.")
        found = {name: take(saved.tensors, name, like) for name, like in expected.items()}
        agent._model.policy.load_state_dict(
            {
                name.removeprefix("policy."): torch.from_numpy(array.copy())
                for name, array in found.items()
                if name.startswith("policy.")
            }
        )
        if agent._normaliser is not None:
            seen = agent._seen()
            if (found["seen.variance"] < 0).any():
                raise AgentFileError("Expected nothing below 0 in 'seen.variance'.")
            seen.mean, seen.var = found["seen.mean"].copy(), found["seen.variance"].copy()
        agent.history = to_history(saved.tensors)
        agent._n_steps = saved.n_steps
        agent._can_learn = False
        return agent

    def __repr__(self) -> str:
        return (
            f"<{self.algorithm.value} on {self.spec.env_id}: {self.n_parameters:,} parameters "
            f"after {self.num_timesteps:,} steps>"
        )

    def note(self, n_steps: int, infos: Sequence[Mapping[str, Any]]) -> None:
        """Counts a step, and keeps the episodes that ended with it."""
        self._n_steps = n_steps
        for info in infos:
            if "episode" in info:
                total, length = float(info["episode"]["r"]), int(info["episode"]["l"])
                self.history.append(EpisodeSummary(n_steps, total, length, self.n_parameters))

    def _act(self, seen: NDArray[np.float64], deterministic: bool) -> list[Any]:
        rows = seen.astype(np.float32)
        if self._normaliser is not None:
            rows = np.asarray(self._normaliser.normalize_obs(rows))
        actions, _ = self._model.policy.predict(rows, deterministic=deterministic)
        if self.spec.action_grid is None:
            return [int(action) + self.spec.action_offset for action in actions]
        return list(actions)

    def _seen(self) -> RunningMeanStd:
        assert self._normaliser is not None
        assert isinstance(self._normaliser.obs_rms, RunningMeanStd)
        return self._normaliser.obs_rms

    def _tensors(self) -> dict[str, NDArray]:
        tensors = {
            f"policy.{name}": value.numpy()
            for name, value in self._model.policy.state_dict().items()
        }
        if self._normaliser is not None:
            seen = self._seen()
            tensors |= {"seen.mean": seen.mean, "seen.variance": seen.var}
        return tensors


class _Listener(BaseCallback):
    """Keeps count, and calls back between updates."""

    def __init__(
        self,
        agent: Reference,
        callback: Callable[[Reference], bool | None] | None,
        advance: Callable[[int], None],
    ) -> None:
        super().__init__()
        self._agent = agent
        self._callback = callback
        self._advance = advance
        self._told = agent.num_timesteps
        self._goes_on = True

    def tell(self) -> None:
        """Calls back, once for each number of steps."""
        steps = self._agent.num_timesteps
        if steps > self._told and self._goes_on:
            self._advance(steps - self._told)
            self._told = steps
            if self._callback is not None:
                self._goes_on = self._callback(self._agent) is not False

    def _on_rollout_start(self) -> None:
        self.tell()

    def _on_step(self) -> bool:
        if self._goes_on:
            self._agent.note(self.model.num_timesteps, self.locals["infos"])
        return self._goes_on


def _check_actions(algorithm: Algorithm, spec: TaskSpec) -> None:
    needs_box = {Algorithm.SB3_SAC: True, Algorithm.SB3_QRDQN: False}.get(algorithm)
    if needs_box is not None and needs_box != (spec.action_grid is not None):
        kind = "continuous" if needs_box else "discrete"
        raise ValueError(f"{algorithm.value} needs {kind} actions, which {spec.env_id} lacks.")
