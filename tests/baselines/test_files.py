"""Files of baselines: what is saved comes back, and nothing in a file is believed."""

import json
import struct

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import save_file

from ao2viz import AO2, baselines
from ao2viz.baselines.algorithm import Algorithm
from ao2viz.baselines.files import FORMAT
from ao2viz.store.errors import AgentFileError

QUICK = {"envs": 2, "rollout": 16, "epochs": 2, "minibatch": 16, "hidden": 8}
OURS = [algorithm for algorithm in Algorithm if not algorithm.is_reference]


def trained(algorithm=Algorithm.DAC_PPO, env="CartPole-v1", **settings):
    return baselines.make(algorithm, env, 3, **(QUICK | settings)).learn(200)


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    path = tmp_path_factory.mktemp("baselines") / "one.safetensors"
    trained(normalise=True).save(path)
    return path


def taken_apart(path):
    with safe_open(path, framework="numpy") as opened:
        tensors = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118
        return json.loads(opened.metadata()[FORMAT]), tensors


def put_together(path, manifest, tensors):
    text = manifest if isinstance(manifest, str) else json.dumps(manifest)
    save_file(tensors, path, {FORMAT: text})
    return path


@pytest.mark.parametrize("env", ["CartPole-v1", "Pendulum-v1"])
@pytest.mark.parametrize("algorithm", OURS)
def test_what_is_saved_comes_back(tmp_path, algorithm, env):
    agent = trained(algorithm, env, normalise=True)
    agent.save(tmp_path / "a.safetensors")
    back = baselines.load(tmp_path / "a.safetensors")
    assert (back.algorithm, back.settings, back.seed) == (algorithm, agent.settings, 3)
    assert back.num_timesteps == agent.num_timesteps
    np.testing.assert_array_equal(back.evaluate(5), agent.evaluate(5))
    np.testing.assert_array_equal(back.history.to_array(), agent.history.to_array())
    back.save(tmp_path / "b.safetensors")
    (said, first), (again, second) = (
        taken_apart(tmp_path / f"{name}.safetensors") for name in "ab"
    )
    assert {**said, "created_at": ""} == {**again, "created_at": ""}
    for name, array in first.items():
        np.testing.assert_array_equal(second[name], array, err_msg=name)


def test_a_loaded_one_goes_on_learning_alike(sound):
    first, again = (baselines.load(sound).learn(64) for _ in range(2))
    assert first.num_timesteps == 224 + 64
    np.testing.assert_array_equal(first.evaluate(3), again.evaluate(3))
    assert len(first.history) >= len(baselines.load(sound).history)


def test_an_environment_can_be_given(sound):
    assert baselines.load(sound, "CartPole-v1").env.spec.id == "CartPole-v1"
    with pytest.raises(ValueError, match=r"learned on CartPole-v1.*Give it its own"):
        baselines.load(sound, "Pendulum-v1")


def test_only_its_own_ending_is_written(tmp_path):
    with pytest.raises(ValueError, match=r"ends in \.safetensors"):
        trained().save(tmp_path / "a.pt")
    assert not list(tmp_path.iterdir())


def changed(**fields):
    return lambda manifest, tensors: (manifest | fields, tensors)


def setting(**fields):
    return lambda m, tensors: (m | {"settings": m["settings"] | fields}, tensors)


def task(**fields):
    return lambda m, tensors: (m | {"task": m["task"] | fields}, tensors)


def tensor(name, change):
    return lambda manifest, tensors: (manifest, tensors | {name: change(tensors[name])})


def without(name):
    return lambda m, tensors: (m, {key: one for key, one in tensors.items() if key != name})


WEIGHT = "network.policies.weights.0"
HOSTILE = {
    "no manifest": (lambda m, tensors: ("", tensors), "Expected a manifest in JSON"),
    "no JSON": (lambda m, tensors: ("{", tensors), "Expected a manifest in JSON"),
    "a list": (lambda m, tensors: ("[]", tensors), "manifest to be an object"),
    "huge manifest": (lambda m, tensors: ("[" * 2_000_000, tensors), "does not say it is one"),
    "another format": (changed(format="ao2viz-agent"), "Expected the format 'ao2viz-baseline'"),
    "a newer format": (changed(format_version=2), "newer ao2viz: its format is 2, and 1"),
    "format 0": (changed(format_version=0), "whole number of at least 1"),
    "an unknown algorithm": (
        changed(algorithm="os.system"),
        "'algorithm' in the manifest to be ppo",
    ),
    "a seed below 0": (changed(seed=-1), "'seed' in the manifest"),
    "steps in words": (changed(n_steps="many"), "'n_steps' in the manifest"),
    "a module to import": (task(env_id="os:CartPole-v1"), "plain id, but got 'os:CartPole-v1'"),
    "no features": (task(features=[]), "at least one feature"),
    "an unknown setting": (setting(evil=1), "A setting does not fit: There is no setting 'evil'"),
    "a setting out of range": (setting(options=10**9), "from 1 to 64 for options"),
    "too many numbers": (setting(options=64, hidden=1024), "Choose fewer options"),
    "NaN as setting": (setting(gamma=float("nan")), "NaN is not JSON"),
    "a setting missing": (
        lambda m, t: (m | {"settings": {k: v for k, v in m["settings"].items() if k != "clip"}}, t),
        "Expected all settings, but 'clip' is missing",
    ),
    "a tensor missing": (without(WEIGHT), f"{WEIGHT}' to be float32 of shape .* is missing"),
    "a tensor more": (lambda m, t: (m, t | {"x": np.zeros(1)}), "no tensor called 'x'"),
    "another shape": (tensor(WEIGHT, lambda a: a[:, :1]), "but it is float32 of shape"),
    "another type": (tensor(WEIGHT, lambda a: a.astype(np.float64)), "but it is float64 of"),
    "strange numbers": (tensor(WEIGHT, lambda a: a.astype(np.int8)), "Expected plain numbers in"),
    "not finite": (tensor(WEIGHT, lambda a: a * np.inf), "Expected finite numbers in"),
    "variance below 0": (tensor("seen.variance", lambda a: -a - 1), "nothing below 0 in 'seen.var"),
    "history of another shape": (tensor("history", lambda a: a[:, :2]), "training history"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused_in_one_line(tmp_path, sound, name):
    change, words = HOSTILE[name]
    path = put_together(tmp_path / "evil.safetensors", *change(*taken_apart(sound)))
    with pytest.raises(AgentFileError, match=words) as caught:
        baselines.load(path)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 500


def broken(content: bytes):
    header = int.from_bytes(content[:8], "little")
    yield "empty", b""
    yield "text", b"hello"
    yield "cut short", content[: len(content) // 2]
    yield "more behind", content + b"more"
    yield "header of any length", struct.pack("<Q", 2**60) + content[8:]
    yield "header damaged", content[:8] + b"\xff" * header + content[8 + header :]


def test_a_broken_file_is_refused(tmp_path, sound):
    for name, content in broken(sound.read_bytes()):
        path = tmp_path / "broken.safetensors"
        path.write_bytes(content)
        with pytest.raises(AgentFileError, match=r"broken.*Expected a safetensors file"):
            baselines.load(path)
        assert name


def test_what_is_no_baseline_is_refused(tmp_path, sound):
    with pytest.raises(AgentFileError, match="There is no file"):
        baselines.load(tmp_path / "none.safetensors")
    save_file({"a": np.zeros(1)}, tmp_path / "other.safetensors")
    with pytest.raises(AgentFileError, match="does not say it is one"):
        baselines.load(tmp_path / "other.safetensors")
    AO2("CartPole-v1").save(tmp_path / "agent.ao2")
    with pytest.raises(AgentFileError, match="Expected a safetensors file"):
        baselines.load(tmp_path / "agent.ao2")
