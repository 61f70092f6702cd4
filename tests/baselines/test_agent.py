"""The compared algorithms from outside: they repeat, answer, and say what is wrong."""

import gymnasium as gym
import numpy as np
import pytest
import torch

from ao2viz import AO2, baselines
from ao2viz.baselines import Algorithm
from ao2viz.baselines.agent import OptionAgent
from ao2viz.baselines.normaliser import Moments, RewardScale
from ao2viz.baselines.rollout import Collector
from ao2viz.training.loop import training_seed
from tests import toy_envs

OURS = [algorithm for algorithm in Algorithm if not algorithm.is_reference]
QUICK = {"envs": 2, "rollout": 16, "epochs": 2, "minibatch": 16, "hidden": 8}
BOXED = "Boxed2-v0"


def quick(algorithm=Algorithm.DAC_PPO, env="CartPole-v1", seed=0, steps=96, **settings):
    return baselines.make(algorithm, env, seed, **(QUICK | settings)).learn(steps)


def numbers(agent: OptionAgent) -> dict[str, np.ndarray]:
    return {name: one.numpy().copy() for name, one in agent.network.state_dict().items()}


def same(one: OptionAgent, other: OptionAgent) -> bool:
    a, b = numbers(one), numbers(other)
    return a.keys() == b.keys() and all(np.array_equal(a[name], b[name]) for name in a)


@pytest.mark.parametrize("env", ["CartPole-v1", "Pendulum-v1"])
@pytest.mark.parametrize("algorithm", OURS)
def test_a_seed_repeats_to_the_bit_and_another_differs(algorithm, env):
    first, again, other = (quick(algorithm, env, seed) for seed in (3, 3, 4))
    assert same(first, again)
    assert not same(first, other)
    np.testing.assert_array_equal(first.history.to_array(), again.history.to_array())
    np.testing.assert_array_equal(first.evaluate(3), again.evaluate(3))


@pytest.mark.parametrize("algorithm", [Algorithm.DAC_PPO, Algorithm.PPOC])
def test_one_option_is_ppo_to_the_bit(algorithm):
    alike = {"learning_rate": 1e-3}
    assert same(quick(algorithm, options=1, **alike), quick(Algorithm.PPO, **alike))
    assert not same(quick(algorithm, options=2, hidden=8), quick(algorithm, options=1))


def test_ppo_is_the_textbooks():
    """One epoch over one whole rollout, step by step, with other people's building blocks."""
    agent = baselines.make("ppo", "CartPole-v1", 5, **QUICK | {"epochs": 1, "minibatch": 32})
    twin = baselines.make("ppo", "CartPole-v1", 5, **QUICK)
    agent.learn(1)
    twin._collector = Collector(
        [twin.env, twin.env], twin.spec, lambda: training_seed(twin._rng), twin.history, 0
    )
    rollout = twin._collector.collect(
        twin.network, 16, lambda rows: rows.astype(np.float32), twin._generator, 0
    )
    gamma, trace = twin.settings.gamma, twin.settings.trace
    values, rewards = rollout.low_values, torch.from_numpy(rollout.rewards).float()
    advantages = torch.zeros_like(values)
    for n in range(2):
        running = 0.0
        for t in reversed(range(16)):
            ahead = 0.0 if rollout.terminated[t, n] else float(rollout.next_values[t, n])
            delta = float(rewards[t, n]) + gamma * ahead - float(values[t, n])
            running = delta + (0.0 if rollout.ended[t, n] else gamma * trace * running)
            advantages[t, n] = running
    targets = (advantages + values).flatten()
    flat = advantages.flatten()
    flat = (flat - flat.mean()) / (flat.std() + 1e-8)
    observations = rollout.observations.flatten(0, 1)
    logits = twin.network.policies(observations)[:, 0]
    chosen = torch.distributions.Categorical(logits=logits).log_prob(rollout.actions.flatten())
    ratio = (chosen - rollout.action_log_probs.flatten()).exp()
    surrogate = torch.min(ratio * flat, ratio.clamp(0.8, 1.2) * flat).mean()
    error = torch.nn.functional.mse_loss(twin.network.values(observations)[:, 0], targets)
    optimiser = torch.optim.Adam(twin.network.parameters(), lr=1e-3, eps=1e-5)
    (0.5 * error - surrogate).backward()
    torch.nn.utils.clip_grad_norm_(twin.network.parameters(), 0.5)
    optimiser.step()
    for name, array in numbers(agent).items():
        np.testing.assert_allclose(array, numbers(twin)[name], atol=2e-6, err_msg=name)


def test_steps_are_counted_in_whole_updates_and_going_on_is_never_having_stopped():
    once, twice = quick(steps=96), quick(steps=32).learn(64)
    assert once.num_timesteps == twice.num_timesteps == 96
    assert same(once, twice)
    assert quick(steps=33).num_timesteps == 64
    assert quick(steps=1000, env="CartPole-v1").num_timesteps == 1024


def test_a_callback_can_stop_it():
    seen = []
    agent = baselines.make("ppo", "CartPole-v1", **QUICK)
    agent.learn(1000, lambda one: seen.append(one.num_timesteps) or len(seen) < 3)
    assert seen == [32, 64, 96]
    assert agent.num_timesteps == 96


def test_training_returns_are_those_of_the_environment():
    history = quick(env="Pendulum-v1", steps=1000, normalise=True).history.to_array()
    assert history[:, 2].tolist() == [200] * 4, "Two environments, twice each to the limit."
    assert history[:, 0].tolist() == [400, 400, 800, 800]
    assert (history[:, 1] < -200).all(), "Raw, not as they are learned from."


def test_predict_carries_the_option_and_answers_as_evaluate_plays():
    agent = quick(steps=320)
    env, played = agent.env, []
    for episode in range(3):
        seen, _ = env.reset(seed=2**30 + episode)
        state, total, start = None, 0.0, True
        while True:
            action, state = agent.predict(seen, state, np.array([start]))
            start = False
            assert env.action_space.contains(action)
            seen, reward, terminated, truncated, _ = env.step(action)
            total += float(reward)
            if terminated or truncated:
                break
        played.append(total)
    assert played == agent.evaluate(3).tolist()


def test_predict_takes_batches_and_begins_episodes_where_it_is_told():
    agent = quick(steps=320)
    rows = np.random.default_rng(0).normal(size=(6, 4))
    first, state = agent.predict(rows)
    again, restarted = agent.predict(rows, state, episode_start=np.ones(6, bool))
    assert first.tolist() == again.tolist()
    assert state.tolist() == restarted.tolist()
    kept, held = agent.predict(rows, np.full(6, 2))
    assert len(kept) == 6
    assert set(held.tolist()) <= set(range(4))
    drawn = [agent.predict(rows, deterministic=False)[0].tolist() for _ in range(20)]
    assert len({tuple(one) for one in drawn}) > 1


@pytest.mark.parametrize("algorithm", OURS)
def test_actions_of_a_box_use_its_whole_width_and_no_more(algorithm):
    agent = quick(algorithm, BOXED, steps=320)
    action, _ = agent.predict(np.zeros(2))
    assert action.dtype == np.float32
    assert agent.env.action_space.contains(action)


def test_discrete_actions_keep_their_numbers():
    assert toy_envs.Corridor  # Importing it registers the environments.
    agent = quick(env="ShiftedCorridor-v0", steps=64)
    action, _ = agent.predict(np.array([1.0, 0.0]))
    assert agent.env.action_space.contains(action)


def test_evaluation_changes_nothing():
    agent, other = quick(steps=64, normalise=True), quick(steps=64, normalise=True)
    agent.evaluate(2)
    agent.evaluate(2, deterministic=False)
    agent.predict(np.zeros(4), deterministic=False)
    assert same(agent.learn(64), other.learn(64))


def test_evaluation_is_the_same_whoever_else_is_played(monkeypatch):
    agent = quick(steps=200)
    together = agent.evaluate(7)
    monkeypatch.setattr("ao2viz.baselines.playing._WIDTH", 2)
    np.testing.assert_array_equal(agent.evaluate(7), together)


def test_evaluation_begins_where_that_of_ao2_does():
    """The shortest episodes of a hopeless pair differ by their starts alone."""
    seen = []

    class Spying(gym.Wrapper):
        def reset(self, *, seed=None, options=None):
            seen.append(seed)
            return super().reset(seed=seed, options=options)

    ao2 = AO2(Spying(gym.make("CartPole-v1")), warmup_steps=60)
    ao2.evaluate(3, seed=2)
    expected, seen[:] = list(seen), []
    gym.register("Spied-v0", lambda: Spying(gym.make("CartPole-v1")))
    try:
        baselines.make("ppo", "Spied-v0", **QUICK).evaluate(3, seed=2)
    finally:
        del gym.registry["Spied-v0"]
    assert seen == expected


def test_threads_are_given_back():
    torch.set_num_threads(2)
    quick(steps=32).evaluate(1)
    assert torch.get_num_threads() == 2


def test_running_statistics_are_those_of_all_rows():
    rng = np.random.default_rng(0)
    parts = [rng.normal(3, 2, size=(n, 3)) for n in (1, 20, 7)]
    moments = Moments(3)
    for part in parts:
        moments.add(part)
    rows = np.concatenate(parts)
    np.testing.assert_allclose(moments.mean, rows.mean(axis=0))
    np.testing.assert_allclose(moments.variance, rows.var(axis=0))
    assert np.abs(moments.apply(rows * 1000)).max() == 10


def test_rewards_are_scaled_by_returns_that_end_with_their_episode():
    scale = RewardScale(1, gamma=0.5)
    rewards = np.array([[1.0], [1.0], [1.0]])
    ended = np.array([[False], [True], [False]])
    scaled = scale.apply(rewards, ended)
    assert scaled[0, 0] == pytest.approx(1 / np.std([1.0, 1.5, 1.0]), rel=1e-5)
    assert (scaled == scaled[0]).all(), "Scaled alike, not shifted."


WRONG = {
    "algorithm": (("a3c", "CartPole-v1", {}), r"one of ppo, ppoc, dac\+a2c.*but got 'a3c'"),
    "environment": (("ppo", "CartPol-v1", {}), "Could not make the environment 'CartPol-v1'"),
    "setting": (("ppo", "CartPole-v1", {"gama": 0.9}), "no setting 'gama' in ppo.*mean gamma"),
    "range": (("ppoc", "CartPole-v1", {"gamma": 1.5}), "from 0 to 1 for gamma, not 1.5"),
    "whole": (("ppoc", "CartPole-v1", {"envs": 2.5}), "whole number from 1 to 256 for envs"),
    "truth": (("ppoc", "CartPole-v1", {"normalise": 1}), "true or false for normalise"),
    "options": (("ppo", "CartPole-v1", {"options": 2}), "PPO has one policy"),
    "size": (("ppoc", "CartPole-v1", {"options": 64, "hidden": 1024}), "Choose fewer options"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_is_told(name):
    (algorithm, env, settings), words = WRONG[name]
    with pytest.raises(ValueError, match=words):
        baselines.make(algorithm, env, **settings)


def test_an_environment_that_cannot_be_made_twice_is_told():
    with pytest.raises(ValueError, match="Register yours, and give its id"):
        baselines.make("ppo", toy_envs.Boxed())


def test_a_state_that_is_none_of_its_is_refused():
    with pytest.raises(ValueError, match="Expected the state that predict returned, 1 options"):
        quick(steps=32).predict(np.zeros(4), state=np.array([9]))


@pytest.mark.learning
@pytest.mark.parametrize("algorithm", OURS)
def test_it_learns_to_balance(algorithm):
    steps = {Algorithm.PPO: 20_000, Algorithm.DAC_PPO: 20_000}.get(algorithm, 50_000)
    earned = (
        baselines.make(algorithm, "CartPole-v0", seed).learn(steps).evaluate(50).mean()
        for seed in (70, 71)
    )
    assert any(mean >= 150 for mean in earned), "Random play earns about 22."
