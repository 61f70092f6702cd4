"""A rollout made ready to learn from: flat, with the advantages of both MDPs."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import torch
from torch import Tensor

from ao2viz.baselines.advantages import Estimates, estimate
from ao2viz.baselines.rollout import Rollout
from ao2viz.baselines.settings import Settings


@dataclass(frozen=True, eq=False)
class Batch:
    """Steps in any order; `B` of them. What is called old is from before the update."""

    observations: Tensor  # [B, D]
    befores: Tensor  # [B]
    options: Tensor  # [B]
    actions: Tensor  # [B, dims]
    old_over_options: Tensor  # [B, K] π̂
    old_option_log_probs: Tensor  # [B]
    old_action_log_probs: Tensor  # [B]
    low_advantages: Tensor  # [B] in the MDP of actions.
    low_returns: Tensor  # [B]
    high_advantages: Tensor  # [B] in the MDP of options.
    high_returns: Tensor  # [B]

    def __len__(self) -> int:
        """Steps."""
        return len(self.options)

    def at(self, rows: Tensor) -> "Batch":
        """Some of the steps."""
        return Batch(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})


def make_batch(rollout: Rollout, rewards: Tensor, settings: Settings, *, normalised: bool) -> Batch:
    """Advantages of both MDPs, which share rewards, endings and what comes after a step.

    Args:
        rollout: What was done.
        rewards: [T, N] as they are learned from.
        settings: Discount and λ.
        normalised: Whether advantages get mean 0 and standard deviation 1, in each MDP.
    """

    def of(values: Tensor) -> Estimates:
        return estimate(
            rewards,
            values,
            rollout.next_values,
            rollout.terminated,
            rollout.ended,
            settings.gamma,
            settings.trace,
        )

    low, high = of(rollout.low_values), of(rollout.high_values)
    columns = {
        "observations": rollout.observations,
        "befores": rollout.befores,
        "options": rollout.options,
        "actions": rollout.actions,
        "old_over_options": rollout.over_options,
        "old_option_log_probs": rollout.option_log_probs,
        "old_action_log_probs": rollout.action_log_probs,
        "low_advantages": low.normalised() if normalised else low.advantages,
        "low_returns": low.returns,
        "high_advantages": high.normalised() if normalised else high.advantages,
        "high_returns": high.returns,
    }
    return Batch(**{name: column.flatten(0, 1) for name, column in columns.items()})


def minibatches(batch: Batch, size: int, generator: torch.Generator) -> Iterator[Batch]:
    """Every step once, in random order."""
    order = torch.randperm(len(batch), generator=generator)
    for rows in order.split(size):
        yield batch.at(rows)
