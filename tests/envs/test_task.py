import sys

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces

from ao2viz.core.config import Preset, make_config
from ao2viz.envs.catalogue import CATALOGUE
from ao2viz.envs.task import describe, find_levels, make_env, settings_for, to_observation
from tests import toy_envs


class Spaces(gym.Env):
    def __init__(self, observation_space: gym.Space, action_space: gym.Space) -> None:
        self.observation_space = observation_space
        self.action_space = action_space


ROW = spaces.Box(-1, 1, (2,))


@pytest.mark.parametrize("env_id", CATALOGUE)
def test_catalogue_matches_the_real_environment(env_id):
    entry = CATALOGUE[env_id]
    env = make_env(env_id)
    spec = describe(env)
    assert spec.features == entry.features, "The catalogue's features were not taken."
    assert env.observation_space.shape == (len(entry.features),)
    if entry.actions:
        assert spec.action_names == entry.actions
        assert env.action_space.n == len(entry.actions)
    observation, _ = env.reset(seed=0)
    assert to_observation(observation, spec).shape == (spec.n_features,)
    for action in range(spec.n_actions):
        assert env.action_space.contains(spec.to_env_action(action))
    assert (spec.ranges > 0).all()
    for preset in Preset:
        assert settings_for(spec, preset), f"{env_id} has no proven settings for {preset}."
        make_config(preset, settings_for(spec, preset))


@pytest.mark.parametrize("env_id", CATALOGUE)
def test_catalogued_environments_draw_without_a_display(env_id):
    env = make_env(env_id, render=True)
    env.reset(seed=0)
    picture = env.render()
    assert picture.dtype == np.uint8
    assert picture.shape[2] == 3
    assert np.ptp(picture) > 0, "The picture is blank."
    env.close()


def test_cartpole_v0_is_made_without_a_warning(recwarn):
    make_env("CartPole-v0").close()
    assert not [w for w in recwarn if "out of date" in str(w.message)]


def test_what_is_far_too_long_for_an_id_is_not_repeated():
    with pytest.raises(ValueError, match=r"^Expected .* at most 200 characters, but got 1,999\.$"):
        make_env("x" * 1999)


def test_unknown_environments_get_plain_names_and_their_own_ranges():
    spec = describe(make_env("Corridor-v0"))
    assert [f.name for f in spec.features] == ["feature 0", "feature 1"]
    assert spec.action_names == ("action 0", "action 1")
    assert spec.ranges.tolist() == [5.0, 5.0]
    assert settings_for(spec, Preset.PAPER) == {}
    assert settings_for(spec, Preset.ANTICIPATING) == {"levels": 5}


def test_levels_follow_the_number_of_features():
    assert [find_levels(n) for n in (1, 2, 3, 4, 6, 8, 100)] == [11, 5, 4, 3, 2, 1, 1]


def test_unbounded_features_count_as_one_wide():
    assert describe(make_env("Boxed2-v0")).ranges.tolist() == [1.0, 1.0]


@pytest.mark.parametrize(("dims", "bins"), [(1, 5), (2, 3), (3, 3)])
def test_continuous_actions_become_a_grid(dims, bins):
    env = make_env(f"Boxed{dims}-v0")
    spec = describe(env)
    assert spec.n_actions == bins**dims
    assert spec.action_bins == bins
    rows = [spec.to_env_action(action) for action in range(spec.n_actions)]
    assert len({tuple(row) for row in rows}) == spec.n_actions
    assert all(env.action_space.contains(row) for row in rows)
    assert np.min(rows) == -1
    assert np.max(rows) == 1


def test_action_bins_choose_the_grid():
    spec = describe(make_env("Pendulum-v1"), 3)
    assert spec.action_grid.ravel().tolist() == [-2, 0, 2]
    assert spec.action_names == ("torque −2", "torque 0", "torque +2")


def test_discrete_actions_may_start_anywhere():
    env = make_env("ShiftedCorridor-v0")
    spec = describe(env)
    assert [spec.to_env_action(a) for a in range(spec.n_actions)] == [5, 6]


def test_observations_are_copied_and_widened():
    env = make_env("WholeCorridor-v0")
    spec = describe(env)
    raw, _ = env.reset(seed=1)
    observation = to_observation(raw, spec)
    before = observation.copy()
    env.step(1)
    assert observation.dtype == np.float64
    assert observation.tolist() == before.tolist()


@pytest.mark.parametrize(
    ("observations", "actions", "words"),
    [
        (spaces.Discrete(4), spaces.Discrete(2), "one row of numbers.*FlattenObservation"),
        (spaces.Box(0, 1, (2, 2)), spaces.Discrete(2), "one row of numbers.*FlattenObservation"),
        (spaces.Box(0, 1, (0,)), spaces.Discrete(2), "one row of numbers"),
        (ROW, spaces.MultiDiscrete([2, 2]), "Discrete.*bounded Box of one to three"),
        (ROW, spaces.Box(-1, 1, (4,)), "bounded Box of one to three"),
        (ROW, spaces.Box(-np.inf, np.inf, (1,)), "bounded Box of one to three"),
        (ROW, spaces.Discrete(5000), "at most 1,000 actions.*5,000"),
    ],
)
def test_what_does_not_fit_is_refused_in_words(observations, actions, words):
    with pytest.raises(ValueError, match=words):
        describe(Spaces(observations, actions))


@pytest.mark.parametrize(
    ("env_id", "bins", "words"),
    [
        ("CartPole-v1", 3, "action_bins is for continuous actions; CartPole-v1"),
        ("Pendulum-v1", 1, "action_bins from 2 to 101.*got 1"),
        ("Pendulum-v1", 2.5, "action_bins from 2 to 101.*got 2.5"),
        ("Boxed3-v0", 11, "at most 1,000 actions.*1,331.*fewer action_bins"),
    ],
)
def test_action_bins_that_do_not_fit_are_refused(env_id, bins, words):
    with pytest.raises(ValueError, match=words):
        describe(make_env(env_id), bins)


@pytest.mark.parametrize(
    ("env_id", "words"),
    [
        ("CartPole-v7", r"make the environment 'CartPole-v7'.*Did you mean CartPole-v1"),
        ("Pendulum-v0", r"Please use `Pendulum-v1` instead"),
        ("no_such_module:Env-v0", "No module named 'no_such_module'"),
        ("", "Could not make the environment ''"),
    ],
)
def test_an_environment_that_cannot_be_made_says_why(env_id, words):
    with pytest.raises(ValueError, match=words):
        make_env(env_id)


def test_a_box2d_task_without_box2d_says_which_extra_brings_it(monkeypatch):
    # None in the table of modules is how Python says that there is no such module.
    monkeypatch.setitem(sys.modules, "Box2D", None)
    monkeypatch.delitem(sys.modules, "gymnasium.envs.box2d.lunar_lander", raising=False)
    monkeypatch.delitem(sys.modules, "gymnasium.envs.box2d", raising=False)
    with pytest.raises(ValueError, match=r"pip install 'ao2viz\[box2d\]'"):
        make_env("LunarLander-v3")


def test_the_lander_is_told_in_metres_and_degrees():
    spec = describe(make_env("LunarLander-v3"))
    shown = {f.name: (f.scale, f.unit) for f in spec.features}
    lander = make_env("LunarLander-v3").unwrapped
    observation, _ = lander.reset(seed=3)
    for _ in range(20):
        observation, *_ = lander.step(1)
    velocity = lander.lander.linearVelocity
    told = {f.name: x * f.scale for f, x in zip(spec.features, observation, strict=True)}
    assert told["velocity across"] == pytest.approx(velocity.x, rel=1e-4)
    assert told["velocity up"] == pytest.approx(velocity.y, rel=1e-4)
    turning = np.degrees(lander.lander.angularVelocity)
    assert told["angular velocity"] == pytest.approx(turning, rel=1e-4)
    width = lander.lander.position.x - 10.0  # The pad is in the middle of 20 m.
    assert told["across from the pad"] == pytest.approx(width, abs=1e-3)
    assert shown["height"] == (pytest.approx(20 / 3), "m")


def test_an_id_with_a_module_imports_it():
    assert describe(make_env("tests.toy_envs:Corridor-v0", render=True)).env_id == "Corridor-v0"


def test_an_environment_that_cannot_draw_is_made_without_pictures():
    assert make_env("Boxed1-v0", render=True).render_mode is None
    assert make_env("tests.toy_envs:Boxed1-v0", render=True).render_mode is None


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ([1.0], r"shape \(2,\).*Corridor-v0.*shape \(1,\)"),
        ([[1.0, 2.0]], r"shape \(2,\).*shape \(1, 2\)"),
        ([1.0, np.nan], "Corridor-v0 gave feature 1 = nan"),
        ({"position": 1}, "2 numbers from Corridor-v0, but got dict"),
        (None, r"2 numbers from Corridor-v0|shape \(2,\)"),
    ],
)
def test_observations_that_do_not_fit_are_refused(raw, words):
    spec = describe(gym.make("Corridor-v0"))
    with pytest.raises(ValueError, match=words):
        to_observation(raw, spec)


def test_a_bare_environment_goes_by_its_class():
    assert describe(toy_envs.Corridor()).env_id == "Corridor"
