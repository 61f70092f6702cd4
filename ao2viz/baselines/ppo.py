"""PPO: Schulman et al., *Proximal Policy Optimization Algorithms* (2017), arXiv:1707.06347.

The low MDP of the double actor-critics, whose state is (s, o), is learned with the same loss; with
one option there is nothing else, and that is PPO.
"""

from collections.abc import Callable

import torch
from torch import Tensor, nn

from ao2viz.baselines.batch import Batch, minibatches
from ao2viz.baselines.network import OptionNetwork
from ao2viz.baselines.settings import Settings

Loss = Callable[[OptionNetwork, Batch, Settings], Tensor]


def clipped(log_probs: Tensor, old: Tensor, advantages: Tensor, clip: float) -> Tensor:
    """Equation 7: − mean min(r·A, clip(r, 1 − ε, 1 + ε)·A), with r = π / π_old."""
    ratios = (log_probs - old).exp()
    bounded = ratios.clamp(1 - clip, 1 + clip)
    return -torch.minimum(ratios * advantages, bounded * advantages).mean()


def ppo_loss(network: OptionNetwork, batch: Batch, settings: Settings) -> Tensor:
    """Equation 9 of what each option does: clip(π_o(a|s)) + ½ (R_low − q(s, o))²."""
    log_probs = network.action_log_prob(batch.observations, batch.options, batch.actions)
    acting = clipped(log_probs, batch.old_action_log_probs, batch.low_advantages, settings.clip)
    return acting + low_critic_loss(network, batch)


def low_critic_loss(network: OptionNetwork, batch: Batch) -> Tensor:
    """½ (R_low − q(s, o))², the mean over steps."""
    values = network.values(batch.observations).gather(1, batch.options[:, None]).squeeze(1)
    return 0.5 * (batch.low_returns - values).square().mean()


def learn_loss(
    network: OptionNetwork,
    optimiser: torch.optim.Optimizer,
    batch: Batch,
    settings: Settings,
    generator: torch.Generator,
    loss: Loss,
) -> None:
    """Goes through a batch `epochs` times, in minibatches, down one loss."""
    for _ in range(settings.epochs):
        for part in minibatches(batch, settings.minibatch, generator):
            descend(network, optimiser, loss(network, part, settings), settings.max_gradient)


def update_ppo(
    network: OptionNetwork,
    optimiser: torch.optim.Optimizer,
    batch: Batch,
    settings: Settings,
    generator: torch.Generator,
) -> None:
    """One update of PPO."""
    learn_loss(network, optimiser, batch, settings, generator, ppo_loss)


def descend(
    network: OptionNetwork, optimiser: torch.optim.Optimizer, loss: Tensor, max_gradient: float
) -> None:
    """One step of gradient descent, the gradient's norm cut to `max_gradient`."""
    optimiser.zero_grad()
    loss.backward()
    nn.utils.clip_grad_norm_(network.parameters(), max_gradient)
    optimiser.step()
