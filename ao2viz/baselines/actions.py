"""What a network's outputs mean as actions: one of several, or a point in a box."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from ao2viz.envs.task import TaskSpec


@dataclass(frozen=True)
class DiscreteActions:
    """One of `count` actions; outputs are logits, an action is its index."""

    count: int
    offset: int  # The environment's number of the first.

    @property
    def outputs(self) -> int:
        """How many numbers a policy gives."""
        return self.count

    @property
    def free(self) -> int:
        """Free parameters of the spread; the logits say it already."""
        return 0

    def log_prob(self, outputs: Tensor, spread: Tensor, actions: Tensor) -> Tensor:
        """[B] log-probabilities of actions [B, 1] under outputs [B, A]."""
        del spread
        return functional.log_softmax(outputs, dim=-1).gather(-1, actions.long()).squeeze(-1)

    def sample(self, outputs: Tensor, spread: Tensor, generator: torch.Generator) -> Tensor:
        """[B, 1] actions drawn."""
        del spread
        return torch.multinomial(outputs.softmax(dim=-1), 1, generator=generator).float()

    def best(self, outputs: Tensor) -> Tensor:
        """[B, 1] the most probable actions."""
        return outputs.argmax(dim=-1, keepdim=True).float()

    def to_env(self, action: NDArray[np.float32]) -> Any:
        """What `env.step` wants for one action."""
        return int(action[0]) + self.offset


@dataclass(frozen=True, eq=False)
class BoxActions:
    """A point of a box; policies are Gaussian around tanh of the outputs, in [-1, 1] an axis."""

    low: NDArray[np.float32]  # [dims] of the environment.
    high: NDArray[np.float32]

    @property
    def outputs(self) -> int:
        """How many numbers a policy gives."""
        return len(self.low)

    @property
    def free(self) -> int:
        """Free parameters of the spread: the standard deviation is their softplus."""
        return len(self.low)

    def log_prob(self, outputs: Tensor, spread: Tensor, actions: Tensor) -> Tensor:
        """[B] log-densities of actions [B, dims] under outputs [B, dims] and spread [B, dims]."""
        std = functional.softplus(spread)
        offsets = (actions - torch.tanh(outputs)) / std
        return (-0.5 * offsets**2 - std.log() - 0.5 * math.log(2 * math.pi)).sum(dim=-1)

    def sample(self, outputs: Tensor, spread: Tensor, generator: torch.Generator) -> Tensor:
        """[B, dims] actions drawn; may lie outside [-1, 1], where the environment's end holds."""
        noise = torch.randn(outputs.shape, generator=generator, dtype=outputs.dtype)
        return torch.tanh(outputs) + functional.softplus(spread) * noise

    def best(self, outputs: Tensor) -> Tensor:
        """[B, dims] the means."""
        return torch.tanh(outputs)

    def to_env(self, action: NDArray[np.float32]) -> Any:
        """What `env.step` wants for one action: −1 is the box's lowest value, 1 its highest."""
        share = (np.clip(action, -1.0, 1.0) + 1.0) / 2.0
        return (self.low + share * (self.high - self.low)).astype(np.float32)


Actions = DiscreteActions | BoxActions


def actions_of(spec: TaskSpec) -> Actions:
    """The actions of a task; the corners of its grid are those of the environment's box."""
    if spec.action_grid is None:
        return DiscreteActions(spec.n_actions, spec.action_offset)
    low, high = spec.action_grid.min(axis=0), spec.action_grid.max(axis=0)
    return BoxActions(low.astype(np.float32), high.astype(np.float32))
