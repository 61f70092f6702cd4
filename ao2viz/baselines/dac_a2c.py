"""DAC+A2C: the two MDPs of Zhang and Whiteson (2019), each learned as in Mnih et al. (2016).

See `dac_ppo`. An advantage actor-critic takes one step down −log π·A for each rollout.
"""

import torch
from torch import Tensor

from ao2viz.baselines.batch import Batch
from ao2viz.baselines.dac_ppo import high_critic_loss
from ao2viz.baselines.network import OptionNetwork, entropy, log_of
from ao2viz.baselines.ppo import descend, low_critic_loss
from ao2viz.baselines.settings import Settings


def a2c_loss(network: OptionNetwork, batch: Batch, settings: Settings) -> Tensor:
    """−log π_o(a|s)·A_low + ½ (R_low − q)², and −log π̂·A_high + ½ (R_high − v)² − c·H(π̂)."""
    log_probs = network.action_log_prob(batch.observations, batch.options, batch.actions)
    loss = -(log_probs * batch.low_advantages).mean() + low_critic_loss(network, batch)
    if network.options == 1:
        return loss
    over_options = network.over_options(batch.observations, batch.befores)
    chosen = log_of(over_options, batch.options)
    loss = loss - (chosen * batch.high_advantages).mean()
    return loss + high_critic_loss(network, batch) - settings.entropy * entropy(over_options).mean()


def update_dac_a2c(
    network: OptionNetwork,
    optimiser: torch.optim.Optimizer,
    batch: Batch,
    settings: Settings,
    generator: torch.Generator,
) -> None:
    """One update: a single step in both MDPs together."""
    del generator
    descend(network, optimiser, a2c_loss(network, batch, settings), settings.max_gradient)
