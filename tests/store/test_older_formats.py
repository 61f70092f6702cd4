"""Files of format 1 still open, decide and learn on."""

import numpy as np
import pytest

from ao2viz import AO2


@pytest.fixture
def format_1(parts, tmp_path):
    """The file as format 1 would have it: a setting more, no slopes, room for all voters' ends."""
    manifest = parts.manifest
    manifest["format_version"] = 1
    manifest["settings"] |= {"split_distance": 0.2, "voters": 16}
    lacking = ("think_ahead", "think_limit", "action_smoothing", "impression", "max_depth")
    for name in (*lacking, "cleansing"):
        del manifest["settings"][name]
    for name in [name for name in parts.members if name.endswith("decisions/slopes.npy")]:
        parts.remove(name)
    for name, padding in (("end_ids", -1), ("end_shares", 0)):
        array = parts.array(f"learner/imagination_{name}.npy")
        room = ((0, 0), (0, 0), (0, 16 - array.shape[2]))
        wide = np.pad(array, room, constant_values=padding)
        parts.set_array(f"learner/imagination_{name}.npy", wide)
    return parts.write(tmp_path / "old.ao2")


def test_it_opens_and_decides_as_it_would_today(format_1, agent):
    old = AO2.load(format_1)
    for observation in np.random.default_rng(0).normal(0.0, 0.3, (50, 4)):
        assert old.decide(observation).action == agent.decide(observation).action


def test_its_episodes_had_no_outlook(format_1):
    decisions = [
        decision for episode in AO2.load(format_1).episodes for decision in episode.decisions
    ]
    assert decisions
    assert not any(decision.slopes.any() for decision in decisions)
    assert all(decision.plan is None for decision in decisions)


def test_its_agent_did_not_think_ahead_and_can(format_1, tmp_path):
    old = AO2.load(format_1)
    assert vars(old.config)["think_ahead"] == vars(old.config)["think_limit"] == 0
    old.set_think_ahead(2)
    assert old.decide([0.0, 0.1, 0.0, 0.1]).plan is not None
    old.save(tmp_path / "new.ao2")
    assert vars(AO2.load(tmp_path / "new.ao2").config)["think_ahead"] == 2


def test_its_agent_had_none_of_the_behaviour_settings(format_1):
    old = AO2.load(format_1)
    settings = vars(old.config)
    assert (settings["action_smoothing"], settings["impression"], settings["max_depth"]) == (
        1,
        0,
        0,
    )
    assert all(episode.action_smoothing == 1.0 for episode in old.episodes)


def test_it_learns_on_and_is_saved_in_todays_format(format_1, tmp_path):
    old = AO2.load(format_1)
    assert "split_distance" not in vars(old.config)
    old.learn(300)
    old.save(tmp_path / "new.ao2")
    again = AO2.load(tmp_path / "new.ao2")
    np.testing.assert_array_equal(again.forest.weights, old.forest.weights)
    np.testing.assert_array_equal(again.learn(100).forest.weights, old.learn(100).forest.weights)


def test_room_for_too_few_ends_is_refused(parts, tmp_path):
    array = parts.array("learner/imagination_end_ids.npy")
    parts.set_array("learner/imagination_end_ids.npy", np.ascontiguousarray(array[:, :, :3]))
    path = parts.write(tmp_path / "narrow.ao2")
    with pytest.raises(ValueError, match="imagination_end_ids"):
        AO2.load(path)
