"""PPO, PPOC, DAC+A2C and DAC+PPO as a Python programmer meets them: as AO2, but networks."""

import dataclasses
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import gymnasium as gym
import numpy as np
import torch
from numpy.typing import NDArray

from ao2viz.baselines.actions import actions_of
from ao2viz.baselines.algorithm import Algorithm
from ao2viz.baselines.batch import Batch, make_batch
from ao2viz.baselines.dac_a2c import update_dac_a2c
from ao2viz.baselines.dac_ppo import update_dac_ppo
from ao2viz.baselines.files import SavedBaseline, take, to_history, write
from ao2viz.baselines.making import Maker
from ao2viz.baselines.network import NO_OPTION, OptionNetwork
from ao2viz.baselines.normaliser import Moments, RewardScale
from ao2viz.baselines.playing import play_together
from ao2viz.baselines.ppo import update_ppo
from ao2viz.baselines.ppoc import update_ppoc
from ao2viz.baselines.rollout import Collector, Rollout, draw_options
from ao2viz.baselines.settings import Settings, make_settings
from ao2viz.baselines.threads import one_thread
from ao2viz.envs.task import TaskSpec, to_observation
from ao2viz.recording.history import History
from ao2viz.store.errors import AgentFileError
from ao2viz.training.loop import evaluation_seed, to_seed, training_seed
from ao2viz.training.progress import advancing

Update = Callable[[OptionNetwork, torch.optim.Optimizer, Batch, Settings, torch.Generator], None]
_UPDATES: Mapping[Algorithm, Update] = {
    Algorithm.PPO: update_ppo,
    Algorithm.PPOC: update_ppoc,
    Algorithm.DAC_A2C: update_dac_a2c,
    Algorithm.DAC_PPO: update_dac_ppo,
}
_MAX_PARAMETERS = 20_000_000
_ADAM_EPSILON = 1e-5


class OptionAgent:
    """An agent that learns by one of our four algorithms; see `baselines.make`.

    The same environment, algorithm, seed and settings give the same agent, to the bit, on the same
    machine and version of PyTorch. It computes on one thread: the networks are too small for more.
    """

    def __init__(
        self, algorithm: Algorithm, make: Maker, seed: int, overrides: Mapping[str, Any]
    ) -> None:
        self.algorithm = algorithm
        self._make = make
        self.spec: TaskSpec = make.spec
        self.settings: Settings = make_settings(algorithm, self.spec.env_id, overrides)
        self.seed = to_seed(seed)
        self.history = History()
        self._actions = actions_of(self.spec)
        _check_size(self.spec.n_features, self.settings)
        self.network = OptionNetwork(
            self.spec.n_features,
            self._actions,
            self.settings.options,
            self.settings.hidden,
            self.seed % 2**63,
        )
        self._optimiser = torch.optim.Adam(
            self.network.parameters(), self.settings.learning_rate, eps=_ADAM_EPSILON
        )
        self._moments = Moments(self.spec.n_features)
        self._scale = RewardScale(self.settings.envs, self.settings.gamma)
        self._collector: Collector | None = None
        self._begin(0)

    @property
    def num_timesteps(self) -> int:
        """Environment steps learned from so far, those of all environments together."""
        return self._n_steps

    @property
    def n_parameters(self) -> int:
        """Numbers that are learned."""
        return sum(one.numel() for one in self.network.parameters())

    @property
    def steps_per_update(self) -> int:
        """`learn` stops at multiples of it."""
        return self.settings.steps_per_update

    @property
    def env(self) -> gym.Env:
        """One more of its environments; a new one at every call."""
        return self._make()

    def learn(
        self,
        total_timesteps: int,
        callback: Callable[["OptionAgent"], bool | None] | None = None,
        progress_bar: bool = False,
    ) -> Self:
        """Learns for so many more environment steps, rounded up to whole updates.

        Going on equals never having stopped, but after a load: then episodes begin afresh.

        Args:
            total_timesteps: Steps to take, of all environments together.
            callback: Called after every update with the agent; returning False stops early.
            progress_bar: Shows one in the terminal.

        Raises:
            ValueError: If the environment gives numbers that are not finite.
        """
        goal = self._n_steps + total_timesteps
        with one_thread(), advancing(total_timesteps, is_shown=progress_bar) as advance:
            while self._n_steps < goal:
                self._update()
                advance(self.steps_per_update)
                if callback is not None and callback(self) is False:
                    break
        return self

    def predict(
        self,
        observation: NDArray,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Actions in the environment's own terms, as recurrent policies of others give them.

        Args:
            observation: One of shape [D], or a batch [n, D].
            state: What the call before returned: the option that acted, [n]. None begins episodes.
            episode_start: Whether an episode begins with this observation; for a batch one truth
                a row.
            deterministic: The most probable option and action; else both are drawn.

        Returns:
            What `env.step` wants, or an array with one action a row; and the next `state`.

        Raises:
            ValueError: If observation or state do not fit.
        """
        is_batch = np.ndim(observation) == 2
        rows = observation if is_batch else [observation]
        seen = np.stack([to_observation(row, self.spec) for row in rows])
        before = np.full(len(seen), NO_OPTION) if state is None else np.array(state, np.int64)
        if (
            before.shape != (len(seen),)
            or not ((before >= NO_OPTION) & (before < self.settings.options)).all()
        ):
            raise ValueError(
                f"Expected the state that predict returned, {len(seen)} options below "
                f"{self.settings.options}, but got {state!r}."
            )
        if episode_start is not None:
            before = np.where(episode_start, NO_OPTION, before)
        with one_thread():
            actions, options = self._act(seen, before, None if deterministic else self._drawing)
        return (np.array(actions) if is_batch else actions[0]), options

    def evaluate(
        self, episodes: int = 100, seed: int = 0, deterministic: bool = True
    ) -> NDArray[np.float64]:
        """The return of each of so many episodes, on the starts of `AO2.evaluate`; learns nothing.

        Normalisers are as they are. Each episode begins without an option before it.
        """
        drawing = None if deterministic else torch.Generator().manual_seed(seed)

        def act(
            seen: NDArray[np.float64], before: NDArray, begins: NDArray[np.bool_]
        ) -> tuple[Sequence[Any], NDArray]:
            return self._act(seen, np.where(begins, NO_OPTION, before), drawing)

        seeds = [evaluation_seed(seed, i) for i in range(episodes)]
        with one_thread():
            return play_together(self._make, self.spec, act, seeds)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes everything to one .safetensors file.

        Raises:
            ValueError: If the name ends otherwise.
            OSError: If the file cannot be written.
        """
        settings = dataclasses.asdict(self.settings)
        tensors = {name: array.copy() for name, array in self._tensors().items()}
        tensors["history"] = self.history.to_array()
        write(
            path,
            SavedBaseline(self.algorithm, self.spec, settings, self.seed, self._n_steps, tensors),
        )

    @classmethod
    def from_saved(cls, saved: SavedBaseline, make: Maker) -> Self:
        """The agent of a file that was read; see `baselines.load`.

        Raises:
            AgentFileError: If settings or numbers do not fit.
        """
        try:
            agent = cls(saved.algorithm, make, saved.seed, saved.settings)
        except ValueError as error:
            raise AgentFileError(f"A setting does not fit: {error}") from error
        if lacking := {f.name for f in dataclasses.fields(Settings)} - saved.settings.keys():
            raise AgentFileError(f"Expected all settings, but {min(lacking)!r} is missing.")
        agent._restore(saved.tensors)
        agent._begin(saved.n_steps)
        return agent

    def __repr__(self) -> str:
        return (
            f"<{self.algorithm.value} on {self.spec.env_id}: {self.n_parameters:,} parameters "
            f"after {self.num_timesteps:,} steps>"
        )

    def _begin(self, n_steps: int) -> None:
        """Sets the step count, and the random numbers that go on from there."""
        self._n_steps = n_steps
        seeds = np.random.SeedSequence([self.seed, n_steps]).generate_state(3, np.uint64)
        self._rng = np.random.default_rng(seeds[0])
        self._generator = torch.Generator().manual_seed(int(seeds[1] >> np.uint64(1)))
        self._drawing = torch.Generator().manual_seed(int(seeds[2] >> np.uint64(1)))

    def _update(self) -> None:
        settings = self.settings
        if self._collector is None:
            self._collector = Collector(
                [self._make() for _ in range(settings.envs)],
                self.spec,
                lambda: training_seed(self._rng),
                self.history,
                self._n_steps,
            )
        rollout = self._collector.collect(
            self.network, settings.rollout, self._normalise, self._generator, self.n_parameters
        )
        self._n_steps = self._collector.n_steps
        rewards = torch.from_numpy(self._scaled(rollout))
        batch = make_batch(
            rollout, rewards, settings, normalised=self.algorithm is not Algorithm.DAC_A2C
        )
        _UPDATES[self.algorithm](self.network, self._optimiser, batch, settings, self._generator)
        # After the update: within a rollout the networks see one and the same scale.
        if settings.normalise:
            self._moments.add(rollout.raw.reshape(-1, self.spec.n_features))

    def _normalise(self, rows: NDArray[np.float64]) -> NDArray[np.float32]:
        return self._moments.apply(rows) if self.settings.normalise else rows.astype(np.float32)

    def _scaled(self, rollout: Rollout) -> NDArray[np.float32]:
        if not self.settings.normalise:
            return rollout.rewards.astype(np.float32)
        return self._scale.apply(rollout.rewards, rollout.ended.numpy())

    def _act(
        self, seen: NDArray[np.float64], before: NDArray, drawing: torch.Generator | None
    ) -> tuple[list[Any], NDArray]:
        """Actions for `env.step` and the options that chose them, drawn or the most probable."""
        with torch.no_grad():
            observations = torch.from_numpy(self._normalise(seen))
            over_options = self.network.over_options(observations, torch.from_numpy(before))
            options = draw_options(over_options, drawing)
            actions = self.network.draw_action(observations, options, drawing).numpy()
        return [self._actions.to_env(action) for action in actions], options.numpy()

    def _tensors(self) -> dict[str, NDArray]:
        """Every number that is learned or counted, by name; the arrays are the live ones."""
        tensors = {
            f"network.{name}": value.numpy() for name, value in self.network.state_dict().items()
        }
        for i, one in enumerate(self.network.parameters()):
            state = self._optimiser.state.get(one, {})
            zeros = torch.zeros_like(one)
            for name, default in (
                ("step", torch.zeros(())), ("exp_avg", zeros), ("exp_avg_sq", zeros),
            ):  # fmt: skip
                tensors[f"optimiser.{i}.{name}"] = state.get(name, default).numpy()
        for name, moments in (("seen", self._moments), ("earned", self._scale.moments)):
            tensors[f"{name}.mean"] = moments.mean
            tensors[f"{name}.variance"] = moments.variance
            tensors[f"{name}.count"] = np.array(moments.count)
        return tensors

    def _restore(self, tensors: Mapping[str, NDArray]) -> None:
        expected = self._tensors()
        if unknown := sorted(tensors.keys() - expected.keys() - {"history"}):
            raise AgentFileError(f"Expected no tensor called {unknown[0]!r}.")
        found = {name: take(tensors, name, like) for name, like in expected.items()}
        for name, array in found.items():
            is_count = name.endswith((".count", ".step", ".variance", ".exp_avg_sq"))
            if is_count and (array < 0).any():
                raise AgentFileError(f"Expected nothing below 0 in {name!r}.")
        network = {
            name.removeprefix("network."): torch.from_numpy(array.copy())
            for name, array in found.items()
            if name.startswith("network.")
        }
        self.network.load_state_dict(network)
        for i, one in enumerate(self.network.parameters()):
            self._optimiser.state[one] = {
                name: torch.from_numpy(found[f"optimiser.{i}.{name}"].copy())
                for name in ("step", "exp_avg", "exp_avg_sq")
            }
        for name, moments in (("seen", self._moments), ("earned", self._scale.moments)):
            moments.mean = found[f"{name}.mean"].copy()
            moments.variance = found[f"{name}.variance"].copy()
            moments.count = float(found[f"{name}.count"])
        self.history = to_history(tensors)


def _check_size(n_features: int, settings: Settings) -> None:
    size = settings.options * settings.hidden * (n_features + settings.hidden)
    if size > _MAX_PARAMETERS:
        raise ValueError(
            f"Expected networks of at most some {_MAX_PARAMETERS:,} numbers, but {size:,} would be "
            f"needed. Choose fewer options or hidden units."
        )
