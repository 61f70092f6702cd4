"""Steps that are taken side by side in several environments, and learned from together."""

from collections.abc import Callable
from dataclasses import dataclass

import gymnasium as gym
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from ao2viz.baselines.network import NO_OPTION, OptionNetwork, log_of, mix
from ao2viz.envs.task import TaskSpec, to_observation
from ao2viz.recording.history import EpisodeSummary, History

Normalise = Callable[[NDArray[np.float64]], NDArray[np.float32]]


@dataclass(frozen=True, eq=False)
class Rollout:
    """`T` steps of each of `N` environments; tensors are [T, N, …]."""

    raw: NDArray[np.float64]  # [T, N, D] observations in the environment's own units.
    observations: Tensor  # [T, N, D] as the network sees them.
    befores: Tensor  # Option before the step; NO_OPTION where an episode begins.
    options: Tensor
    actions: Tensor  # [T, N, dims]
    rewards: NDArray[np.float64]  # As the environment gave them.
    terminated: Tensor
    ended: Tensor  # Terminated or truncated.
    over_options: Tensor  # [T, N, K] π̂ as it was then.
    action_log_probs: Tensor  # As they were then.
    values: Tensor  # [T, N, K] q(s, ·) as it was then.
    next_values: Tensor  # Σ π̂(·|o, s')·q(s', ·) where the step truly led.

    @property
    def option_log_probs(self) -> Tensor:
        """[T, N] of the options taken, as they were then."""
        flat = log_of(self.over_options.flatten(0, 1), self.options.flatten())
        return flat.view(self.options.shape)

    @property
    def low_values(self) -> Tensor:
        """Values in the low MDP, whose state is (s, o): q(s, o), [T, N]."""
        return self.values.gather(-1, self.options[..., None]).squeeze(-1)

    @property
    def high_values(self) -> Tensor:
        """Values in the high MDP, whose state is (o₋₁, s): Σ π̂·q, [T, N]."""
        return (self.over_options * self.values).sum(dim=-1)


class Collector:
    """Owns the environments in which an agent learns; episodes go on between rollouts."""

    def __init__(
        self,
        envs: list[gym.Env],
        spec: TaskSpec,
        next_seed: Callable[[], int],
        history: History,
        n_steps: int,
    ) -> None:
        self._envs = envs
        self._spec = spec
        self._next_seed = next_seed
        self._history = history
        self.n_steps = n_steps
        """Of all environments together, those before this collector was made included."""
        self._seen = np.stack([self._reset(env) for env in envs])
        self._before = torch.full((len(envs),), NO_OPTION)
        self._totals = np.zeros(len(envs))
        self._lengths = np.zeros(len(envs), np.int64)

    def collect(
        self,
        network: OptionNetwork,
        steps: int,
        normalise: Normalise,
        generator: torch.Generator,
        n_parameters: int,
    ) -> Rollout:
        """Acts for so many steps in every environment.

        Raises:
            ValueError: If an environment gives numbers that are not finite.
        """
        columns: dict[str, list] = {name: [] for name in (
            "raw", "observations", "befores", "options", "actions", "rewards", "terminated",
            "ended", "over_options", "action_log_probs", "values", "next_values",
        )}  # fmt: skip
        with torch.no_grad():
            for _ in range(steps):
                row = self._step(network, normalise, generator, n_parameters)
                for name, value in row.items():
                    columns[name].append(value)
        raw, rewards = np.stack(columns.pop("raw")), np.stack(columns.pop("rewards"))
        tensors = {name: torch.stack(rows) for name, rows in columns.items()}
        return Rollout(raw=raw, rewards=rewards, **tensors)

    def _step(
        self,
        network: OptionNetwork,
        normalise: Normalise,
        generator: torch.Generator,
        n_parameters: int,
    ) -> dict[str, NDArray | Tensor]:
        raw, before = self._seen, self._before
        observations = torch.from_numpy(normalise(raw))
        over_options = mix(*network.endings_and_choice(observations), before)
        options = draw_options(over_options, generator)
        actions = network.draw_action(observations, options, generator)
        log_probs = network.action_log_prob(observations, options, actions)
        reached = np.empty_like(raw)
        rewards = np.empty(len(raw))
        terminated = np.zeros(len(raw), np.bool_)
        ended = np.zeros(len(raw), np.bool_)
        chosen = actions.numpy()
        for i, env in enumerate(self._envs):
            seen, reward, terminated[i], truncated, _ = env.step(network.actions.to_env(chosen[i]))
            reached[i] = to_observation(seen, self._spec)
            rewards[i] = reward
            ended[i] = terminated[i] or truncated
        if not np.isfinite(rewards).all():
            raise ValueError(f"Expected finite rewards, but {self._spec.env_id} gave {rewards}.")
        final = torch.from_numpy(normalise(reached))
        next_values = (network.over_options(final, options) * network.values(final)).sum(dim=-1)
        self._finish(reached, rewards, ended, n_parameters)
        self._before = torch.where(torch.from_numpy(ended), NO_OPTION, options)
        return {
            "raw": raw,
            "observations": observations,
            "befores": before,
            "options": options,
            "actions": actions,
            "rewards": rewards,
            "terminated": torch.from_numpy(terminated),
            "ended": torch.from_numpy(ended),
            "over_options": over_options,
            "action_log_probs": log_probs,
            "values": network.values(observations),
            "next_values": next_values,
        }

    def _finish(
        self,
        reached: NDArray[np.float64],
        rewards: NDArray[np.float64],
        ended: NDArray[np.bool_],
        n_parameters: int,
    ) -> None:
        """Counts the step, and begins new episodes where old ones ended."""
        self.n_steps += len(self._envs)
        self._totals += rewards
        self._lengths += 1
        for i in np.flatnonzero(ended):
            total, length = float(self._totals[i]), int(self._lengths[i])
            self._history.append(EpisodeSummary(self.n_steps, total, length, n_parameters))
            self._totals[i], self._lengths[i] = 0.0, 0
            reached[i] = self._reset(self._envs[i])
        self._seen = reached

    def _reset(self, env: gym.Env) -> NDArray[np.float64]:
        return to_observation(env.reset(seed=self._next_seed())[0], self._spec)


def draw_options(over_options: Tensor, generator: torch.Generator | None) -> Tensor:
    """Options drawn from π̂, or the most probable one where there is no generator: [B]."""
    if over_options.shape[1] == 1:
        return torch.zeros(len(over_options), dtype=torch.long)
    if generator is None:
        return over_options.argmax(dim=-1)
    return torch.multinomial(over_options, 1, generator=generator).squeeze(1)
