"""PPOC: Klissarov et al., *Learnings Options End-to-End for Continuous Action Tasks* (2017).

arXiv:1712.00004, on Bacon, Harb and Precup, *The Option-Critic Architecture* (AAAI 2017). Written
from the papers' formulas. One advantage, that of the option and the action taken, serves both the
options and the policy over them.
"""

import torch
from torch import Tensor

from ao2viz.baselines.batch import Batch
from ao2viz.baselines.network import NO_OPTION, OptionNetwork, entropy, log_of
from ao2viz.baselines.ppo import learn_loss, ppo_loss
from ao2viz.baselines.settings import Settings


def ppoc_loss(network: OptionNetwork, batch: Batch, settings: Settings) -> Tensor:
    """clip(π_o) + ½ (R − q)² − log μ(o)·A − c·H(μ) + β_{o₋₁}·[q(s, o₋₁) − Σ μ·q + margin].

    The bracket is the termination gradient theorem's advantage (Bacon et al., theorem 2), a number
    that nothing learns through: an option ends sooner where others promise more. It says nothing
    where an episode begins. One option has neither μ nor β.
    """
    loss = ppo_loss(network, batch, settings)
    if network.options == 1:
        return loss
    endings, choice = network.endings_and_choice(batch.observations)
    loss = loss - (log_of(choice, batch.options) * batch.low_advantages).mean()
    loss = loss - settings.entropy * entropy(choice).mean()
    return loss + ending_loss(endings, choice, network.values(batch.observations), batch, settings)


def ending_loss(
    endings: Tensor, choice: Tensor, values: Tensor, batch: Batch, settings: Settings
) -> Tensor:
    """Mean over all steps of β_{o₋₁}·[q(s, o₋₁) − Σ μ·q + margin], 0 where there is no o₋₁."""
    held = batch.befores.clamp_min(0)[:, None]
    better = values.gather(1, held).squeeze(1) - (choice * values).sum(dim=-1) + settings.margin
    counts = (batch.befores != NO_OPTION).to(endings.dtype)
    return (counts * endings.gather(1, held).squeeze(1) * better.detach()).mean()


def update_ppoc(
    network: OptionNetwork,
    optimiser: torch.optim.Optimizer,
    batch: Batch,
    settings: Settings,
    generator: torch.Generator,
) -> None:
    """One update of PPOC."""
    learn_loss(network, optimiser, batch, settings, generator, ppoc_loss)
