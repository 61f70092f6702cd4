"""Each loss against its formula, written out with numpy, and its gradient against differences."""

from dataclasses import fields

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from ao2viz.baselines.actions import BoxActions, DiscreteActions
from ao2viz.baselines.advantages import estimate
from ao2viz.baselines.batch import Batch
from ao2viz.baselines.dac_a2c import a2c_loss
from ao2viz.baselines.dac_ppo import high_loss
from ao2viz.baselines.network import NO_OPTION, OptionNetwork, mix
from ao2viz.baselines.ppo import ppo_loss
from ao2viz.baselines.ppoc import ending_loss, ppoc_loss
from ao2viz.baselines.settings import Settings

K, D, B = 3, 2, 12
SETTINGS = Settings(options=K, entropy=0.05, margin=0.02)
LOSSES = [ppo_loss, high_loss, a2c_loss, ppoc_loss]
ACTIONS = [
    DiscreteActions(4, 0),
    BoxActions(np.full(2, -2, np.float32), np.full(2, 2, np.float32)),
]


def network_of(actions, options=K) -> OptionNetwork:
    """Its heads are large, so that nothing is near uniform, and everything has a gradient."""
    network = OptionNetwork(D, actions, options, 5, seed=3).double()
    with torch.no_grad():
        generator = torch.Generator().manual_seed(1)
        for one in network.parameters():
            one.add_(0.4 * torch.randn(one.shape, generator=generator, dtype=one.dtype))
    return network


def batch_of(network: OptionNetwork) -> Batch:
    generator = torch.Generator().manual_seed(2)
    rng = np.random.default_rng(0)

    def randn(*shape):
        return torch.from_numpy(rng.normal(size=shape))

    observations, k = randn(B, D), network.options
    befores = torch.from_numpy(rng.integers(NO_OPTION, k, B))
    befores[0] = NO_OPTION
    options = torch.from_numpy(rng.integers(0, k, B))
    with torch.no_grad():
        actions = network.draw_action(observations, options, generator).double()
        over_options = network.over_options(observations, befores)
        log_probs = network.action_log_prob(observations, options, actions)
    return Batch(
        observations=observations,
        befores=befores,
        options=options,
        actions=actions,
        old_over_options=torch.softmax(over_options.log() + 0.3 * randn(B, k), dim=1),
        old_option_log_probs=over_options.gather(1, options[:, None])[:, 0].log() + 0.3 * randn(B),
        old_action_log_probs=log_probs + 0.3 * randn(B),
        low_advantages=randn(B),
        low_returns=randn(B),
        high_advantages=randn(B),
        high_returns=randn(B),
    )


def parts(network: OptionNetwork, batch: Batch) -> dict[str, np.ndarray]:
    """What the networks say, as numpy arrays."""
    with torch.no_grad():
        endings, choice = network.endings_and_choice(batch.observations)
        said = {
            "beta": endings,
            "mu": choice,
            "q": network.values(batch.observations),
            "log_pi": network.action_log_prob(batch.observations, batch.options, batch.actions),
        }
    taken = {field.name: getattr(batch, field.name) for field in fields(batch)}
    return {name: tensor.numpy() for name, tensor in (said | taken).items()}


def clipped(log_probs, old, advantages, clip):
    ratio = np.exp(log_probs - old)
    return -np.mean(np.minimum(ratio * advantages, np.clip(ratio, 1 - clip, 1 + clip) * advantages))


def over_options(p):
    """π̂ row by row, as the papers write it."""
    rows = []
    for beta, mu, before in zip(p["beta"], p["mu"], p["befores"], strict=True):
        if before == NO_OPTION:
            rows.append(mu)
        else:
            kept = np.eye(len(mu))[before]
            rows.append((1 - beta[before]) * kept + beta[before] * mu)
    return np.array(rows)


def own(p, name):
    return p[name][np.arange(B), p["options"]]


def expected_ppo(p):
    acting = clipped(p["log_pi"], p["old_action_log_probs"], p["low_advantages"], SETTINGS.clip)
    return acting + 0.5 * np.mean((p["low_returns"] - own(p, "q")) ** 2)


def entropy(rows):
    return np.mean(-(rows * np.log(rows)).sum(axis=1))


def high_critic(p):
    return 0.5 * np.mean((p["high_returns"] - (p["old_over_options"] * p["q"]).sum(axis=1)) ** 2)


def expected_high(p):
    rows = over_options(p)
    log_probs = np.log(rows[np.arange(B), p["options"]])
    acting = clipped(log_probs, p["old_option_log_probs"], p["high_advantages"], SETTINGS.clip)
    return acting - SETTINGS.entropy * entropy(rows) + high_critic(p)


def expected_a2c(p):
    rows = over_options(p)
    low = -np.mean(p["log_pi"] * p["low_advantages"])
    low += 0.5 * np.mean((p["low_returns"] - own(p, "q")) ** 2)
    high = -np.mean(np.log(rows[np.arange(B), p["options"]]) * p["high_advantages"])
    return low + high - SETTINGS.entropy * entropy(rows) + high_critic(p)


def expected_ppoc(p):
    loss = expected_ppo(p) - np.mean(np.log(own(p, "mu")) * p["low_advantages"])
    loss -= SETTINGS.entropy * entropy(p["mu"])
    for i, before in enumerate(p["befores"]):
        if before != NO_OPTION:
            better = p["q"][i, before] - (p["mu"][i] * p["q"][i]).sum() + SETTINGS.margin
            loss += p["beta"][i, before] * better / B
    return loss


@pytest.mark.parametrize("actions", ACTIONS, ids=["discrete", "box"])
@pytest.mark.parametrize(
    ("loss", "expected"),
    [*zip(LOSSES, [expected_ppo, expected_high, expected_a2c, expected_ppoc], strict=True)],
    ids=lambda function: function.__name__,
)
def test_a_loss_is_its_formula(loss, expected, actions):
    network = network_of(actions)
    batch = batch_of(network)
    got = loss(network, batch, SETTINGS).item()
    assert got == pytest.approx(expected(parts(network, batch)), rel=1e-9)


@pytest.mark.parametrize("actions", ACTIONS, ids=["discrete", "box"])
@pytest.mark.parametrize("loss", [ppo_loss, high_loss, a2c_loss])
def test_a_gradient_is_the_slope_of_its_loss(loss, actions):
    network = network_of(actions)
    batch = batch_of(network)
    loss(network, batch, SETTINGS).backward()
    rng = np.random.default_rng(5)
    step, moved = 1e-6, 0
    for one in network.parameters():
        flat = one.detach().view(-1)
        for at in rng.choice(flat.numel(), min(4, flat.numel()), replace=False):
            before = flat[at].item()
            ends = []
            for shift in (step, -step):
                flat[at] = before + shift
                ends.append(loss(network, batch, SETTINGS).item())
            flat[at] = before
            slope = (ends[0] - ends[1]) / (2 * step)
            found = 0.0 if one.grad is None else one.grad.view(-1)[at].item()
            assert found == pytest.approx(slope, rel=1e-4, abs=1e-7)
            moved += abs(slope) > 1e-4
    assert moved > 10, "The losses must depend on what is checked."


def test_an_ending_is_learned_from_what_others_promise_and_changes_nothing_else():
    network = network_of(ACTIONS[0])
    batch = batch_of(network)
    p = parts(network, batch)
    endings, choice = network.endings_and_choice(batch.observations)
    values = network.values(batch.observations)
    endings.retain_grad()
    ending_loss(endings, choice, values, batch, SETTINGS).backward()
    expected = np.zeros((B, K))
    for i, before in enumerate(p["befores"]):
        if before != NO_OPTION:
            average = (p["mu"][i] * p["q"][i]).sum()
            expected[i, before] = (p["q"][i, before] - average + SETTINGS.margin) / B
    np.testing.assert_allclose(endings.grad, expected, rtol=1e-9)
    still = [network.critic, network.master, network.policies]
    assert all(one.grad is None for part in still for one in part.parameters())
    assert any(one.grad is not None for one in network.endings.parameters())


PROBABILITIES = st.lists(st.floats(0.0, 1.0), min_size=5, max_size=5)


@given(PROBABILITIES, PROBABILITIES, st.integers(NO_OPTION, 4))
def test_the_policy_over_options_is_one(beta, weights, before):
    mu = torch.softmax(torch.tensor([weights], dtype=torch.float64) * 20, dim=1)
    endings = torch.tensor([beta], dtype=torch.float64)
    row = mix(endings, mu, torch.tensor([before]))[0]
    assert row.sum().item() == pytest.approx(1, abs=1e-12)
    assert (row >= 0).all()
    if before == NO_OPTION:
        np.testing.assert_array_equal(row, mu[0])
    else:  # Only the option before decides whether it ends.
        assert row[before].item() == pytest.approx(
            1 - beta[before] * (1 - mu[0, before].item()), abs=1e-12
        )


def test_a_time_limit_looks_ahead_and_an_end_does_not():
    ones = torch.ones(3, 1)
    yes, no = torch.ones(3, 1, dtype=torch.bool), torch.zeros(3, 1, dtype=torch.bool)
    last = torch.tensor([[False], [True], [False]])

    def of(terminated, ended):
        return estimate(ones, 2 * ones, 10 * ones, terminated, ended, 0.5, 0.8).advantages[:, 0]

    ahead = 1 + 0.5 * 10 - 2  # What one step says: reward + discount · V(next) − V.
    assert of(yes, yes).tolist() == [1 - 2] * 3
    assert of(no, yes).tolist() == [ahead] * 3
    trace = 0.5 * 0.8
    two = ahead + trace * ahead
    assert of(no, no).tolist() == pytest.approx([ahead + trace * two, two, ahead])
    assert of(no, last).tolist() == pytest.approx([two, ahead, ahead])
    assert of(last, last).tolist() == pytest.approx([ahead + trace * -1, -1, ahead])


@given(
    st.lists(st.floats(-5, 5), min_size=2, max_size=2),
    st.lists(st.floats(0.1, 10), min_size=2, max_size=2),
    st.lists(st.floats(-3, 3), min_size=2, max_size=2),
)
def test_actions_reach_from_end_to_end_of_a_box_and_no_further(low, width, action):
    bottom = np.array(low, np.float32)
    top = bottom + np.array(width, np.float32)
    executed = BoxActions(bottom, top).to_env(np.array(action, np.float32))
    share = (np.clip(action, -1, 1) + 1) / 2
    np.testing.assert_allclose(executed, bottom + share * (top - bottom), rtol=1e-5, atol=1e-5)


def test_log_probabilities_are_those_of_what_is_drawn():
    generator = torch.Generator().manual_seed(0)
    discrete, box = ACTIONS
    logits = torch.tensor([[0.0, 1.0, 2.0, -1.0]]).repeat(20_000, 1)
    drawn = discrete.sample(logits, torch.empty(0), generator)
    shares = torch.bincount(drawn[:, 0].long()) / len(drawn)
    every = torch.arange(4.0)[:, None]
    told = discrete.log_prob(logits[:4], torch.empty(0), every).exp()
    np.testing.assert_allclose(shares, told, atol=0.015)
    outputs, spread = torch.zeros(20_000, 2) + 0.3, torch.zeros(20_000, 2) - 0.5
    drawn = box.sample(outputs, spread, generator)
    std = float(np.log1p(np.exp(-0.5)))
    np.testing.assert_allclose(drawn.mean(0), np.tanh(0.3), atol=0.02)
    np.testing.assert_allclose(drawn.std(0), std, atol=0.02)
    density = box.log_prob(outputs[:1], spread[:1], torch.tensor([[0.1, 0.6]])).item()
    gaps = (np.array([0.1, 0.6]) - np.tanh(0.3)) / std
    expected = -0.5 * (gaps**2).sum() - 2 * np.log(std * np.sqrt(2 * np.pi))
    assert density == pytest.approx(expected, rel=1e-5)
