"""The networks: K options, a policy over them and one critic, evaluated side by side."""

import torch
from torch import Tensor, nn
from torch.nn import functional

from ao2viz.baselines.actions import Actions

NO_OPTION = -1
"""The option before the first step of an episode."""

_HEAD_SCALE = 1e-3  # So that policies begin nearly uniform, and values near 0.
_LEAST = 1e-8  # Of a probability whose logarithm is taken.


class Parallel(nn.Module):
    """`count` separate networks of two tanh layers on the same input, in one multiplication."""

    def __init__(
        self, count: int, n_in: int, hidden: int, n_out: int, generator: torch.Generator
    ) -> None:
        super().__init__()
        sizes = [(n_in, hidden, 1.0), (hidden, hidden, 1.0), (hidden, n_out, _HEAD_SCALE)]
        self.weights = nn.ParameterList()
        self.biases = nn.ParameterList()
        for rows, columns, scale in sizes:
            weight = torch.empty(count, rows, columns)
            for one in weight:
                nn.init.orthogonal_(one, scale, generator)
            self.weights.append(nn.Parameter(weight))
            self.biases.append(nn.Parameter(torch.zeros(count, 1, columns)))

    def forward(self, observations: Tensor) -> Tensor:
        """[B, D] to [B, count, n_out]."""
        layers = list(zip(self.weights, self.biases, strict=True))
        flow = observations.expand(len(self.weights[0]), *observations.shape)
        for weight, bias in layers[:-1]:
            flow = torch.tanh(torch.baddbmm(bias, flow, weight))
        weight, bias = layers[-1]
        return torch.baddbmm(bias, flow, weight).transpose(0, 1)


class OptionNetwork(nn.Module):
    """π_o(a|s) and β_o(s) of each option, μ(o|s), and q(s, o).

    A single option needs neither β nor μ, so it has none: then this is PPO's pair of networks.
    """

    def __init__(
        self, n_features: int, actions: Actions, options: int, hidden: int, seed: int
    ) -> None:
        super().__init__()
        generator = torch.Generator().manual_seed(seed)
        self.actions = actions
        self.options = options
        self.policies = Parallel(options, n_features, hidden, actions.outputs, generator)
        self.critic = Parallel(1, n_features, hidden, options, generator)
        self.spread = nn.Parameter(torch.zeros(options, actions.free))
        if options > 1:
            self.endings = Parallel(options, n_features, hidden, 1, generator)
            self.master = Parallel(1, n_features, hidden, options, generator)

    def values(self, observations: Tensor) -> Tensor:
        """q(s, ·): [B, K]."""
        return self.critic(observations).squeeze(1)

    def endings_and_choice(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """β(s) and μ(·|s): [B, K] each; certainties where there is one option."""
        if self.options == 1:
            ones = observations.new_ones(len(observations), 1)
            return ones, ones
        endings = torch.sigmoid(self.endings(observations).squeeze(-1))
        return endings, functional.softmax(self.master(observations).squeeze(1), dim=-1)

    def over_options(self, observations: Tensor, before: Tensor) -> Tensor:
        """π̂(·|o₋₁, s): [B, K] for the options before [B]; see `mix`."""
        return mix(*self.endings_and_choice(observations), before)

    def action_log_prob(self, observations: Tensor, options: Tensor, actions: Tensor) -> Tensor:
        """Logarithms of π_o(a|s): [B]."""
        outputs = _of_option(self.policies(observations), options)
        return self.actions.log_prob(outputs, self.spread[options], actions)

    def draw_action(
        self, observations: Tensor, options: Tensor, generator: torch.Generator | None
    ) -> Tensor:
        """Actions drawn from π_o(·|s), or the best one where there is no generator: [B, dims]."""
        outputs = _of_option(self.policies(observations), options)
        if generator is None:
            return self.actions.best(outputs)
        return self.actions.sample(outputs, self.spread[options], generator)


def mix(endings: Tensor, choice: Tensor, before: Tensor) -> Tensor:
    """The policy over options of the high MDP: π̂(o|o', s) = (1 − β_{o'})·1[o = o'] + β_{o'}·μ(o|s).

    Equation 2 of Zhang and Whiteson (2019). At an episode's start π̂ = μ. The termination that
    counts is that of the option before, whichever option comes next, so rows add up to 1.

    Args:
        endings: β of every option, [B, K].
        choice: μ, [B, K]; rows add up to 1.
        before: o', [B]; NO_OPTION at the start of an episode.
    """
    held = before.clamp_min(0)[:, None]
    ends = torch.where((before == NO_OPTION)[:, None], 1.0, endings.gather(1, held))
    kept = torch.zeros_like(choice).scatter_(1, held, 1.0)
    return (1 - ends) * kept + ends * choice


def log_of(probabilities: Tensor, chosen: Tensor) -> Tensor:
    """[B] logarithms of the chosen [B] among [B, K] probabilities."""
    return probabilities.gather(1, chosen[:, None]).squeeze(1).clamp_min(_LEAST).log()


def entropy(probabilities: Tensor) -> Tensor:
    """[B] of rows of probabilities."""
    return -(probabilities * probabilities.clamp_min(_LEAST).log()).sum(dim=-1)


def _of_option(outputs: Tensor, options: Tensor) -> Tensor:
    """[B, n] of each row's own option among [B, K, n]."""
    return outputs[torch.arange(len(outputs)), options]
