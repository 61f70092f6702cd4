"""Smooth actions: what is executed is partly what was executed before, wherever the agent acts."""

import time

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ao2viz import AO2, Preset
from ao2viz.envs.motion import Motion
from ao2viz.envs.task import describe
from ao2viz.training.loop import evaluation_seed
from ao2viz.ui.frames import FrameStore
from tests import toy_envs

# Its observation is the action that it was given.
BOXED = "Boxed2-v0"
SMOOTHING = 0.6


def executed(spec, actions, smoothing=SMOOTHING):
    """[T, dims] the plain way."""
    chosen = spec.action_grid[actions]
    done = [chosen[0]]
    for action in chosen[1:]:
        done.append(smoothing * action + (1 - smoothing) * done[-1])
    return np.array(done).astype(np.float32)


def smooth_agent(env=BOXED, preset=Preset.ANTICIPATING, **settings):
    quick = {"warmup_steps": 60} if preset is Preset.ANTICIPATING else {"threshold": 0.95}
    return AO2(env, preset, seed=1, action_smoothing=SMOOTHING, **quick, **settings)


@given(st.lists(st.integers(0, 8), min_size=1, max_size=60), st.floats(1e-6, 1.0))
def test_motion_follows_the_papers_rule_inside_the_actions_bounds(actions, smoothing):
    env = toy_envs.Boxed(dims=2, width=0.7)
    spec = describe(env)
    motion = Motion(spec, smoothing)
    for _ in range(2):  # The second episode begins as the first did.
        done = np.array([motion.execute(action) for action in actions])
        np.testing.assert_array_equal(done, executed(spec, actions, smoothing))
        assert all(env.action_space.contains(action) for action in done)
        np.testing.assert_array_equal(done[0], spec.to_env_action(actions[0]))
        motion.begin()


@pytest.mark.parametrize("preset", Preset)
def test_discrete_actions_cannot_be_smoothed(preset):
    with pytest.raises(ValueError, match="discrete: there is no mean of 'push left' and 'push ri"):
        AO2("CartPole-v1", preset, action_smoothing=0.9)
    with pytest.raises(ValueError, match="action_smoothing between 1e-06 and 1, but got 0"):
        AO2("Pendulum-v1", preset, action_smoothing=0)
    assert AO2("CartPole-v1", preset, action_smoothing=1).config.action_smoothing == 1.0


@pytest.mark.parametrize("preset", Preset)
def test_learning_and_recording_execute_smoothed_actions(preset):
    agent = smooth_agent(preset=preset)
    stepper = agent.stepper()
    for _ in range(12):
        while not stepper.step().has_ended:
            pass
        episode = stepper.episode()
        assert episode.is_training
        expected = executed(agent.spec, episode.actions)
        np.testing.assert_array_equal(episode.observations[1:], expected)
    agent.settle()
    recorded = agent.record_episode(0)
    expected = executed(agent.spec, recorded.actions)
    np.testing.assert_array_equal(recorded.observations[1:], expected)
    assert recorded.action_smoothing == SMOOTHING


@pytest.mark.parametrize("preset", Preset)
def test_evaluating_recording_and_predicting_step_by_step_are_the_same(preset):
    agent = smooth_agent("Pendulum-v1", preset).learn(700)
    seed = evaluation_seed(4, 0)
    episode = agent.record_episode(seed)
    earned = agent.evaluate(1, seed=4)[0]
    assert earned == pytest.approx(episode.total_reward, rel=1e-12)  # Summed in another order.
    env = gym.make("Pendulum-v1")
    observation, state, starts, total = env.reset(seed=seed)[0], None, True, 0.0
    for expected in episode.observations[1:]:
        action, state = agent.predict(observation, state=state, episode_start=np.array([starts]))
        observation, reward, _, truncated, _ = env.step(action)
        np.testing.assert_array_equal(observation, expected)
        starts, total = truncated, total + float(reward)
    assert total == earned
    plain = AO2("Pendulum-v1", preset, seed=1)
    plain._learner.set_state(agent._learner.get_state())
    assert abs(plain.evaluate(1, seed=4)[0] - total) > 1.0, "Smoothing makes a difference here."


def test_predict_keeps_what_each_environment_of_a_batch_executed():
    agent = smooth_agent().learn(100)
    rows = np.random.default_rng(0).normal(size=(3, 2)).astype(np.float32)
    first, state = agent.predict(rows)
    np.testing.assert_array_equal(first, [agent.predict(row)[0] for row in rows])
    other = -rows
    chosen, _ = agent.predict(other)
    second, state = agent.predict(other, state=state, episode_start=np.array([False, True, False]))
    np.testing.assert_array_equal(second[1], chosen[1])
    blend = SMOOTHING * chosen.astype(np.float64) + (1 - SMOOTHING) * first
    np.testing.assert_allclose(second[[0, 2]], blend[[0, 2]], atol=1e-7)
    assert state.shape == (3, 2)
    assert second.dtype == np.float32
    with pytest.raises(ValueError, match=r"numbers of shape \(3, 2\), but got shape \(2, 2\)"):
        agent.predict(rows, state=state[:2])


def test_stable_baselines_hands_the_state_on():
    evaluation = pytest.importorskip("stable_baselines3.common.evaluation")
    vec_env = pytest.importorskip("stable_baselines3.common.env_util")
    agent = smooth_agent("Boxed1-v0").learn(300)
    for envs in (vec_env.make_vec_env(lambda: gym.make("Boxed1-v0"), 2), gym.make("Boxed1-v0")):
        mean, _ = evaluation.evaluate_policy(agent, envs, n_eval_episodes=4, warn=False)
        assert mean == pytest.approx(agent.evaluate(1)[0], abs=1e-6)


def test_a_recorded_episode_is_drawn_again_from_its_file(tmp_path):
    agent = smooth_agent("Pendulum-v1").learn(300)
    agent.record_episode(0)
    agent.save(tmp_path / "smooth.ao2")
    loaded = AO2.load(tmp_path / "smooth.ao2")
    assert loaded.config == agent.config
    episode = loaded.episodes[0]
    assert episode.action_smoothing == SMOOTHING
    env = gym.make("Pendulum-v1")
    observations = [env.reset(seed=episode.seed)[0]]
    observations += [env.step(action)[0] for action in executed(agent.spec, episode.actions)]
    np.testing.assert_array_equal(observations, episode.observations)
    store = FrameStore()
    try:
        deadline = time.monotonic() + 60
        frame, problem = None, ""
        while frame is None and not problem and time.monotonic() < deadline:
            frame, problem = store.get(episode, loaded.spec, len(episode))
            time.sleep(0.02)
        assert frame, problem
    finally:
        store.close()
