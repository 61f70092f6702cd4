"""Attention that drifts, in a file: continued to the bit, or refused."""

import numpy as np
import pytest

from ao2viz import AO2, Preset
from ao2viz.store.files import read
from tests.store.hostile import Parts

SETTINGS = {
    Preset.PAPER: {"threshold": 0.95},
    Preset.ANTICIPATING: {"warmup_steps": 100},
}


@pytest.fixture(params=Preset, scope="module")
def impressed(request, tmp_path_factory):
    preset = request.param
    agent = AO2("CartPole-v1", preset, seed=1, impression=0.5, **SETTINGS[preset]).learn(700)
    path = tmp_path_factory.mktemp("impression") / "a.ao2"
    agent.save(path)
    return agent, path


def test_attention_goes_on_drifting_as_if_never_stopped(impressed):
    agent, path = impressed
    loaded = AO2.load(path)
    assert loaded.config == agent.config
    before = read(path).state["impression"][:4]
    assert (before != 1.0).all()
    stayed = AO2.from_saved(agent.to_saved())
    for one in (loaded, stayed):
        one.learn(900)
    ours, theirs = loaded.to_saved().state, stayed.to_saved().state
    assert ours.keys() == theirs.keys()
    for name in ours:
        np.testing.assert_array_equal(ours[name], theirs[name], err_msg=name)
    assert not np.array_equal(ours["impression"][:4], before)


def test_a_file_without_the_impression_that_its_settings_speak_of_is_refused(impressed, tmp_path):
    parts = Parts.of(impressed[1])
    parts.remove("learner/impression.npy")
    path = parts.write(tmp_path / "a.ao2")
    with pytest.raises(ValueError, match="not sound: Expected an array 'impression'"):
        AO2.load(path)


def test_an_impression_beyond_its_bounds_is_refused(impressed, tmp_path):
    parts = Parts.of(impressed[1])
    array = parts.array("learner/impression.npy")
    array[0] = 1e9
    parts.set_array("learner/impression.npy", array)
    path = parts.write(tmp_path / "a.ao2")
    with pytest.raises(
        ValueError, match=r"not sound: Expected an impression of factors from 0\.25"
    ):
        AO2.load(path)


@pytest.mark.parametrize("preset", Preset)
def test_an_agent_without_impression_has_nothing_of_it_in_its_file(preset, tmp_path):
    AO2("CartPole-v1", preset, **SETTINGS[preset]).learn(150).save(tmp_path / "a.ao2")
    assert "impression" not in read(tmp_path / "a.ao2").state
