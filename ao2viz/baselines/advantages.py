"""Generalised advantage estimates (Schulman et al. 2016), with endings told apart."""

from dataclasses import dataclass

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Estimates:
    """How good each step was in one of the two MDPs; as long as its rollout."""

    advantages: Tensor
    returns: Tensor  # What the critic is to say: advantage + value.

    def normalised(self) -> Tensor:
        """The advantages with mean 0 and standard deviation 1 over the rollout."""
        return (self.advantages - self.advantages.mean()) / (self.advantages.std() + 1e-8)


def estimate(
    rewards: Tensor,
    values: Tensor,
    next_values: Tensor,
    terminated: Tensor,
    ended: Tensor,
    gamma: float,
    trace: float,
) -> Estimates:
    """Estimates for a rollout; every tensor is [T, N].

    Args:
        rewards: Earned by each step.
        values: Of where the step began.
        next_values: Of where it truly led, also where the episode ended there.
        terminated: Whether the task ended with it: nothing comes after. A time limit does not
            count, as the task would go on.
        ended: Whether the episode did, in either way: the next row is another episode.
        gamma: Discount.
        trace: λ.
    """
    differences = rewards + gamma * next_values * ~terminated - values
    advantages = torch.zeros_like(rewards)
    running = torch.zeros_like(rewards[0])
    for t in reversed(range(len(rewards))):
        running = differences[t] + gamma * trace * ~ended[t] * running
        advantages[t] = running
    return Estimates(advantages, advantages + values)
