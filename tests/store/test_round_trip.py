import dataclasses
import json
import os
import signal
import subprocess
import sys
import time
import zipfile

import numpy as np
import pytest

from ao2viz import AO2, Preset
from ao2viz.store import files, manifest
from ao2viz.store.errors import AgentFileError
from ao2viz.store.files import list_agents, read, summary


def assert_same(one: AO2, other: AO2) -> None:
    """Everything two agents hold is equal to the bit."""
    a, b = one.to_saved(), other.to_saved()
    assert a.state.keys() == b.state.keys()
    for name, array in a.state.items():
        assert array.dtype == b.state[name].dtype, name
        assert array.tobytes() == b.state[name].tobytes(), name
    assert a.generator == b.generator
    assert a.history.tobytes() == b.history.tobytes()
    assert list(one.growth) == list(other.growth)
    assert (a.config, a.seed, a.n_steps) == (b.config, b.seed, b.n_steps)


@pytest.mark.parametrize("steps", [40, 900, 3000])
@pytest.mark.parametrize("preset", Preset)
@pytest.mark.parametrize("env_id", ["CartPole-v1", "Pendulum-v1"])
def test_load_and_continue_equals_never_stopped(tmp_path, env_id, preset, steps):
    never_stopped = AO2(env_id, preset, seed=9).learn(steps)
    never_stopped.save(tmp_path / "a.ao2")
    loaded = AO2.load(tmp_path / "a.ao2")
    assert_same(never_stopped, loaded)
    never_stopped.learn(700)
    loaded.learn(700)
    assert_same(never_stopped, loaded)


def test_saving_changes_nothing(tmp_path):
    plain, saved = (AO2("CartPole-v1", seed=2).learn(500) for _ in range(2))
    saved.save(tmp_path / "a.ao2")
    plain.learn(300)
    saved.learn(300)
    assert_same(plain, saved)


def test_a_loaded_agent_decides_alike(agent, file):
    loaded = AO2.load(file)
    assert loaded.evaluate(5).tolist() == agent.evaluate(5).tolist()
    observation = np.array([0.1, -0.2, 0.05, 0.3])
    one, other = agent.decide(observation), loaded.decide(observation)
    assert one.action_values.tolist() == other.action_values.tolist()
    assert one.paths.tolist() == other.paths.tolist()


def test_recorded_episodes_come_back_with_every_decision(agent, file):
    for one, other in zip(agent.episodes, read(file).episodes, strict=True):
        for field in dataclasses.fields(one):
            if field.name != "decisions":
                assert np.array_equal(getattr(one, field.name), getattr(other, field.name))
        for a, b in zip(one.decisions, other.decisions, strict=True):
            for field in dataclasses.fields(a):
                x, y = np.asarray(getattr(a, field.name)), np.asarray(getattr(b, field.name))
                assert (x.shape, x.dtype) == (y.shape, y.dtype), field.name
                assert x.dtype.kind == "O" or x.tobytes() == y.tobytes(), field.name
            assert a.decide_by is b.decide_by


@pytest.mark.parametrize("env_id", ["Pendulum-v1", "MountainCar-v0"])
def test_the_task_comes_back_without_its_environment(tmp_path, env_id):
    agent = AO2(env_id)
    agent.save(tmp_path / "a.ao2")
    spec = read(tmp_path / "a.ao2").spec
    for field in dataclasses.fields(spec):
        if field.name == "features":
            continue
        one, other = getattr(agent.spec, field.name), getattr(spec, field.name)
        assert np.array_equal(one, other), field.name
    for one, other in zip(agent.spec.features, spec.features, strict=True):
        assert (one.name, one.unit, one.scale) == (other.name, other.unit, other.scale)


def test_the_view_of_a_file_is_the_view_of_the_agent(agent, file):
    view, saved = agent.forest, read(file).forest_view()
    for name, array in vars(view).items():
        # What a cleansed option's place once was is not kept.
        keep = view.is_alive if name == "depths" else slice(None)
        if name != "revision":
            assert np.array_equal(array[keep], getattr(saved, name)[keep]), name
    assert saved.revision == view.revision
    assert not saved.weights.flags.writeable


def test_reading_and_viewing_need_no_compiled_code(file):
    code = (
        "import sys, numba; numba.config.DISABLE_JIT = False\n"
        "from numba.core import compiler\n"
        "def refuse(*a, **k): raise SystemExit('compiled something')\n"
        "compiler.compile_extra = refuse\n"
        "from numba.core.caching import FunctionCache\n"
        "FunctionCache.load_overload = refuse\n"
        "from ao2viz.store.files import read\n"
        "saved = read(sys.argv[1]); print(len(saved.forest_view()), len(saved.episodes))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, file], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[1] == "2"


def test_an_agent_of_an_unknown_environment_needs_it_only_to_learn(tmp_path):
    class Mine(type(AO2("tests.toy_envs:Corridor-v0").env.unwrapped)):
        pass

    AO2(Mine(), warmup_steps=50).learn(200).save(tmp_path / "a.ao2")
    loaded = AO2.load(tmp_path / "a.ao2")
    assert loaded.predict(np.array([2.0, 0.0]))[0] in (0, 1)
    with pytest.raises(ValueError, match="Could not make the environment 'Mine'"):
        loaded.learn(10)
    assert AO2.load(tmp_path / "a.ao2", Mine()).learn(10).num_timesteps == 210


def test_another_environment_is_refused(file):
    with pytest.raises(
        ValueError, match=r"learned on CartPole-v1, with 4 features.*Pendulum-v1 has 3"
    ):
        AO2.load(file, "Pendulum-v1")
    assert AO2.load(file, "CartPole-v0").env.spec.id == "CartPole-v0"


def test_summary_tells_what_a_list_shows(agent, file):
    told = summary(file)
    assert told.env_id == "CartPole-v1"
    assert (told.preset, told.seed, told.n_steps) == ("anticipating", 1, 600)
    assert told.n_options == len(agent.forest)
    assert told.n_episodes == 2
    assert told.mean_return == agent.history.to_array()[:, 1][-100:].mean()
    assert told.size == file.stat().st_size
    assert told.created_at.endswith("+00:00")


def test_a_list_shows_broken_files_with_their_error(tmp_path, file):
    (tmp_path / "b.ao2").write_bytes(file.read_bytes())
    (tmp_path / "a.ao2").write_bytes(b"nonsense")
    (tmp_path / ".hidden.ao2").write_bytes(b"nonsense")
    (tmp_path / "note.txt").write_text("not an agent")
    (tmp_path / "folder.ao2").mkdir()
    broken, sound = list_agents(tmp_path)
    assert broken.path.name == "a.ao2"
    assert "Expected a zip file" in broken.error
    assert sound.error == ""
    assert sound.env_id == "CartPole-v1"
    assert list_agents(tmp_path / "nowhere") == []


def test_a_failed_save_leaves_the_old_file_and_no_litter(tmp_path, agent, monkeypatch):
    path = tmp_path / "a.ao2"
    agent.save(path)
    before = path.read_bytes()

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="No space left"):
        agent.save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.ao2"]


def test_the_same_agent_gives_the_same_bytes(tmp_path, agent, monkeypatch):
    real = manifest.to_json
    monkeypatch.setattr(files, "to_json", lambda saved, members, _: real(saved, members, "now"))
    agent.save(tmp_path / "a.ao2")
    agent.save(tmp_path / "b.ao2")
    assert (tmp_path / "a.ao2").read_bytes() == (tmp_path / "b.ao2").read_bytes()


def test_numbers_are_stored_narrow_only_where_nothing_is_lost(file):
    with zipfile.ZipFile(file) as archive:
        members = json.loads(archive.read("manifest.json"))["members"]
    assert members["learner/parents.npy"]["stored"] == "int16"
    assert members["learner/weights.npy"]["stored"] == "float64"
    assert members["episodes/0/observations.npy"]["stored"] == "float32"


def test_values_without_a_narrow_form_survive(tmp_path):
    agent = AO2("CartPole-v1", warmup_steps=20).learn(100)
    odd = np.array([[-0.0, 1e-310, np.pi, float(np.float32(0.1))]])
    rows = len(agent.history)
    agent.history = type(agent.history).from_array(np.repeat(odd, rows, axis=0) * [1, 1, 1, 1])
    agent.save(tmp_path / "a.ao2")
    assert read(tmp_path / "a.ao2").history.tobytes() == agent.history.to_array().tobytes()


def test_old_manifests_are_upgraded_one_version_at_a_time(parts, tmp_path, monkeypatch):
    parts.manifest["format_version"] = 3
    parts.manifest["random_seed"] = parts.manifest.pop("seed")
    path = parts.write(tmp_path / "old.ao2")
    monkeypatch.setattr(manifest, "FORMAT_VERSION", 5)
    upgrades = {
        3: lambda old: {**old, "seed": old["random_seed"] + 1},
        4: lambda old: {**old, "seed": old["seed"] * 10},
    }
    monkeypatch.setattr(manifest, "UPGRADES", upgrades)
    assert read(path).seed == 20
    parts.manifest["format_version"] = 2
    with pytest.raises(AgentFileError, match="never been a format 2"):
        read(parts.write(path))


_SAVE_IN_A_LOOP = """
import itertools, sys
from ao2viz import AO2
from ao2viz.core.decision import DecideBy
agent = AO2.load(sys.argv[1])
for n in itertools.count():
    agent.seed = n  # What tells one save from the next.
    agent.save(sys.argv[1])
    print(n, flush=True)
"""


@pytest.mark.parametrize("moment", range(6))
def test_a_kill_while_saving_leaves_the_old_or_the_new_file_whole(tmp_path, file, moment):
    path = tmp_path / "a.ao2"
    path.write_bytes(file.read_bytes())
    process = subprocess.Popen(
        [sys.executable, "-c", _SAVE_IN_A_LOOP, str(path)], stdout=subprocess.PIPE, text=True
    )
    for _ in range(2 + moment):
        confirmed = int(process.stdout.readline())
    time.sleep(0.004 * moment)
    process.send_signal(signal.SIGKILL)
    rest = process.communicate()[0].split()
    confirmed = int(rest[-1]) if rest else confirmed
    assert read(path).seed in (confirmed, confirmed + 1)
    assert AO2.load(path).num_timesteps == 600
