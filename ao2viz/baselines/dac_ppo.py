"""DAC+PPO: Zhang and Whiteson, *DAC: The Double Actor-Critic Architecture for Learning Options*.

NeurIPS 2019, arXiv:1904.12691. Options are learned as two MDPs at once. In the high one the state
is (o₋₁, s) and the action an option, drawn from π̂ (`network.mix`); in the low one the state is
(s, o) and the action what is executed. Both have the environment's reward and discount, and share
one critic: v_low = q(s, o) and v_high = Σ_o π̂(o|o₋₁, s)·q(s, o), section 4.
"""

import torch
from torch import Tensor

from ao2viz.baselines.batch import Batch
from ao2viz.baselines.network import OptionNetwork, entropy, log_of
from ao2viz.baselines.ppo import clipped, learn_loss, ppo_loss
from ao2viz.baselines.settings import Settings


def high_loss(network: OptionNetwork, batch: Batch, settings: Settings) -> Tensor:
    """clip(π̂(o|o₋₁, s)) − c·H(π̂) + ½ (R_high − Σ π̂_old·q(s, ·))²."""
    over_options = network.over_options(batch.observations, batch.befores)
    acting = clipped(
        log_of(over_options, batch.options),
        batch.old_option_log_probs,
        batch.high_advantages,
        settings.clip,
    )
    critic = high_critic_loss(network, batch)
    return acting - settings.entropy * entropy(over_options).mean() + critic


def high_critic_loss(network: OptionNetwork, batch: Batch) -> Tensor:
    """½ (R_high − Σ π̂_old·q(s, ·))²: the weights are what they were, only q learns from it."""
    values = (batch.old_over_options * network.values(batch.observations)).sum(dim=-1)
    return 0.5 * (batch.high_returns - values).square().mean()


def update_dac_ppo(
    network: OptionNetwork,
    optimiser: torch.optim.Optimizer,
    batch: Batch,
    settings: Settings,
    generator: torch.Generator,
) -> None:
    """One update: PPO in each of the two MDPs, one after the other, in random order.

    With one option the high MDP has nothing to choose and is left out: that is PPO.
    """
    losses = [ppo_loss]
    if network.options > 1:
        losses.append(high_loss)
        if torch.rand(1, generator=generator) < 0.5:
            losses.reverse()
    for loss in losses:
        learn_loss(network, optimiser, batch, settings, generator, loss)
