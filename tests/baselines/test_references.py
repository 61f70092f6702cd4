"""Others' algorithms behind our face: they learn, repeat, are kept, and say what they cannot."""

import itertools
import json

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import save_file

from ao2viz import baselines
from ao2viz.baselines.algorithm import Algorithm
from ao2viz.baselines.files import FORMAT
from ao2viz.baselines.zoo import reference_settings, steps_per_update
from ao2viz.store.errors import AgentFileError

# Each with an environment that it has settings for, and steps that are whole updates.
PAIRS = [
    (Algorithm.SB3_PPO, "CartPole-v1", 512),
    (Algorithm.SB3_PPO, "Acrobot-v1", 4096),
    (Algorithm.SB3_SAC, "Pendulum-v1", 130),
    (Algorithm.SB3_QRDQN, "CartPole-v1", 1280),
    (Algorithm.SB3_QRDQN, "Acrobot-v1", 128),
]


def smallest(told):
    return min(np.diff([0, *told]))


@pytest.mark.parametrize(("algorithm", "env", "steps"), PAIRS)
def test_it_learns_and_is_kept(tmp_path, algorithm, env, steps):
    told = []
    agent = baselines.make(algorithm, env, seed=3)
    agent.learn(steps, lambda one: told.append(one.num_timesteps))
    assert agent.num_timesteps == steps == told[-1]
    assert told == sorted(set(told))
    assert steps_per_update(algorithm, env) == smallest(told)
    assert steps % agent.steps_per_update == 0
    assert len(agent.history) > 0 or env != "CartPole-v1"
    assert (agent.history.to_array()[:, 0] <= steps).all()
    returns = agent.evaluate(3)
    agent.save(tmp_path / "a.safetensors")
    back = baselines.load(tmp_path / "a.safetensors")
    np.testing.assert_array_equal(back.evaluate(3), returns)
    assert (back.num_timesteps, back.n_parameters) == (steps, agent.n_parameters)
    action, state = back.predict(back.env.reset(seed=0)[0])
    assert back.env.action_space.contains(action)
    assert state is None
    with pytest.raises(ValueError, match="cannot go on learning: its optimiser and memory"):
        back.learn(1)


def test_its_network_is_that_of_its_settings():
    agent = baselines.make("sb3-qrdqn", "Acrobot-v1")
    settings = reference_settings(Algorithm.SB3_QRDQN, "Acrobot-v1")
    assert agent.settings == settings  # Making it has left them as they are.
    sizes = [
        6,
        *settings["policy_kwargs"]["net_arch"],
        3 * settings["policy_kwargs"]["n_quantiles"],
    ]
    layers = itertools.pairwise(sizes)
    assert agent.n_parameters == sum((inputs + 1) * outputs for inputs, outputs in layers)


def test_a_seed_repeats_whatever_is_evaluated_in_between():
    def learned(callback):
        return baselines.make("sb3-ppo", "CartPole-v1", seed=5).learn(768, callback).evaluate(5)

    def evaluates(one):
        one.evaluate(1, deterministic=False)

    np.testing.assert_array_equal(learned(None), learned(evaluates))


def test_a_callback_can_stop_it():
    agent = baselines.make("sb3-ppo", "CartPole-v1").learn(100_000, lambda one: False)
    assert agent.num_timesteps <= 512


def test_what_it_cannot_do_is_told():
    with pytest.raises(ValueError, match="sb3-sac needs continuous actions, which CartPole-v1"):
        baselines.make("sb3-sac", "CartPole-v1")
    with pytest.raises(ValueError, match="sb3-qrdqn needs discrete actions, which Pendulum-v1"):
        baselines.make("sb3-qrdqn", "Pendulum-v1")
    with pytest.raises(ValueError, match="takes none; got gamma"):
        baselines.make("sb3-ppo", "CartPole-v1", gamma=0.9)


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    path = tmp_path_factory.mktemp("reference") / "a.safetensors"
    baselines.make("sb3-ppo", "CartPole-v1").learn(1).save(path)
    with safe_open(path, framework="numpy") as opened:
        tensors = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118
        return json.loads(opened.metadata()[FORMAT]), tensors


HOSTILE = {
    "settings of its own": (
        lambda m, t: (m | {"settings": m["settings"] | {"policy_kwargs": {"a": 1}}}, t),
        "only those are known here",
    ),
    "an algorithm that does not fit": (
        lambda m, t: (m | {"algorithm": "sb3-sac"}, t),
        "The task does not fit: sb3-sac needs continuous",
    ),
    "a tensor more": (lambda m, t: (m, t | {"x": np.zeros(1)}), "no tensor called 'x'"),
    "a tensor less": (
        lambda m, t: (m, {k: v for k, v in t.items() if "action_net.bias" not in k}),
        "action_net.bias' to be float32 of shape .* is missing",
    ),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused(tmp_path, parts, name):
    change, words = HOSTILE[name]
    manifest, tensors = change(*parts)
    save_file(tensors, tmp_path / "evil.safetensors", {FORMAT: json.dumps(manifest)})
    with pytest.raises(AgentFileError, match=words):
        baselines.load(tmp_path / "evil.safetensors")
