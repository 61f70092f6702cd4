import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest

import ao2viz
from ao2viz import AO2, DecideBy, GrowthKind, Preset
from ao2viz.core.config import AnticipatingConfig
from ao2viz.envs.catalogue import CATALOGUE
from ao2viz.training.loop import FIRST_EVALUATION_SEED, evaluation_seed
from tests import toy_envs

QUICK = {"warmup_steps": 60}


def same_forest(one: AO2, other: AO2) -> bool:
    a, b = one.forest, other.forest
    return all(
        np.array_equal(x, y) for x, y in zip(vars(a).values(), vars(b).values(), strict=True)
    )


def quick(env="CartPole-v1", seed=0, **settings) -> AO2:
    return AO2(env, seed=seed, **(QUICK | settings))


@pytest.mark.parametrize("preset", Preset)
def test_the_same_seed_gives_the_same_forest_to_the_bit(preset):
    one, other = (AO2("CartPole-v1", preset, seed=4).learn(700) for _ in range(2))
    assert same_forest(one, other)
    assert one.history.summaries == other.history.summaries
    assert not same_forest(one, AO2("CartPole-v1", preset, seed=5).learn(700))


def test_looking_and_asking_change_nothing():
    plain, watched = quick(seed=2), quick(seed=2)

    def look(step):
        watched.decide(step.observation)
        watched.predict(step.observation)
        assert len(watched.forest) >= 0

    plain.learn(300)
    watched.learn(300, callback=look)
    plain.learn(200)
    watched.evaluate(2)
    watched.record_episode(1)
    watched.learn(200)
    assert same_forest(plain, watched)


def test_learning_makes_it_better():
    agent = AO2("CartPole-v1", seed=1)
    before = agent.evaluate(20).mean()
    agent.learn(4000)
    assert agent.evaluate(20).mean() > before + 100


def test_growth_log_tells_which_options_live():
    agent = AO2("CartPole-v1", seed=1).learn(6000)
    alive = set()
    for event in agent.growth:
        if event.kind is GrowthKind.CREATED:
            alive.add(event.option)
        elif event.kind is GrowthKind.REMOVED:
            alive.remove(event.option)
    assert any(event.kind is GrowthKind.REMOVED for event in agent.growth), "Nothing regrew."
    assert alive == set(np.flatnonzero(agent.forest.is_alive).tolist())
    assert agent.history.summaries[-1].options <= len(agent.forest)


def test_history_agrees_with_the_steps_taken():
    agent = quick("Corridor-v0").learn(300)
    summaries = agent.history.summaries
    ends = np.cumsum([s.length for s in summaries])
    assert [s.end_step for s in summaries] == ends.tolist()
    assert 300 - 8 < ends[-1] <= 300
    assert {s.total_reward for s in summaries} <= {-1.0, 0.0, 1.0}


def test_every_call_of_learn_starts_a_fresh_episode():
    agent = quick("Corridor-v0")
    agent.learn(1)
    steps = []
    agent.learn(1, callback=steps.append)
    assert steps[0].observation[1] == 1, "The second feature counts the steps of an episode."


def test_a_training_episode_can_be_replayed_from_seed_and_actions():
    agent = quick(seed=3)
    stepper = agent.stepper()
    for _ in range(200):
        if stepper.step().has_ended:
            break
    episode = stepper.episode()
    assert episode.is_training
    env = gym.make("CartPole-v1")
    observations = [env.reset(seed=episode.seed)[0]]
    for action in episode.actions:
        observations.append(env.step(int(action))[0])
    assert np.array_equal(observations, episode.observations)


def test_terminated_and_truncated_are_never_confused(monkeypatch):
    # In the short corridor walls end the task and eight steps are a time limit; in the long one
    # hardly anything but the time limit of four steps is in reach.
    for env_id, limit, kinds in (
        ("Corridor-v0", 8, {(True, False), (False, True), (False, False)}),
        ("LongCorridor-v0", 4, {(False, True), (False, False)}),
    ):
        agent, told, steps = quick(env_id, seed=1), [], []
        observe = agent._learner.observe

        def listen(decision, reward, observation, terminated, truncated, observe=observe):
            told.append((terminated, truncated))  # noqa: B023  Called in this round only.
            return observe(decision, reward, observation, terminated, truncated)

        monkeypatch.setattr(agent._learner, "observe", listen)
        agent.learn(200, callback=steps.append)
        assert told == [(s.terminated, s.truncated) for s in steps]
        assert set(told) >= kinds
        for step in steps:
            assert step.terminated == (step.reward != 0)
            assert step.truncated == (step.observation[1] == limit)


def test_callback_sees_every_step_and_stops_when_it_says_false():
    agent, seen = quick(), []

    def callback(step):
        seen.append(step.n_steps)
        return len(seen) < 25

    agent.learn(1000, callback=callback)
    assert seen == list(range(1, 26))
    assert agent.num_timesteps == 25


def test_progress_bar_reaches_the_end(capsys):
    quick("Corridor-v0").learn(30, progress_bar=True)
    assert "100%" in capsys.readouterr().out


def test_predict_answers_in_the_environments_terms():
    agent = quick("ShiftedCorridor-v0").learn(100)
    action, state = agent.predict(np.array([2.0, 0.0]), state="kept")
    assert action in (5, 6)
    assert isinstance(action, int)
    assert state == "kept"
    actions, _ = agent.predict(np.array([[2.0, 0.0], [3.0, 1.0], [1.0, 1.0]]))
    assert actions.shape == (3,)
    assert set(actions.tolist()) <= {5, 6}
    assert actions[0] == action


def test_predict_gives_continuous_actions_as_rows():
    agent = quick("Boxed2-v0").learn(100)
    one, _ = agent.predict(np.zeros(2))
    assert one.shape == (2,)
    assert one.dtype == np.float32
    batch, _ = agent.predict(np.zeros((3, 2), np.float32))
    assert batch.shape == (3, 2)
    assert batch.dtype == np.float32
    assert np.array_equal(batch[1], one)


@pytest.mark.parametrize("decide_by", DecideBy)
def test_decide_and_predict_agree(decide_by):
    agent = quick(decide_by=decide_by).learn(400)
    for seed in range(20):
        observation = np.random.default_rng(seed).normal(size=4) * 0.1
        decision = agent.decide(observation)
        assert decision.decide_by is decide_by
        assert agent.predict(observation)[0] == decision.action


def test_an_agent_that_learned_nothing_still_answers():
    for preset in Preset:
        agent = AO2("CartPole-v1", preset)
        assert agent.predict(np.zeros(4))[0] in (0, 1)
        assert len(agent.decide(np.zeros(4)).voters) == 0
        assert len(agent.forest) == 0


def test_who_decides_can_change_at_any_time():
    agent = quick().learn(200)
    agent.set_decide_by("path")
    assert agent.config.decide_by is DecideBy.PATH
    assert len(agent.decide(np.zeros(4)).voters) == 1
    agent.set_decide_by(DecideBy.VOTE)
    assert len(agent.decide(np.zeros(4)).voters) > 1
    with pytest.raises(ValueError, match="'vote', 'path', but got 'luck'"):
        agent.set_decide_by("luck")


def test_how_far_it_thinks_can_change_at_any_time():
    agent = quick(think_limit=5_000).learn(300)
    assert agent.decide(np.zeros(4)).plan is None
    agent.set_think_ahead(2)
    assert (vars(agent.config)["think_ahead"], vars(agent.config)["think_limit"]) == (2, 5_000)
    decision = agent.decide(np.zeros(4))
    assert decision.plan is not None
    assert agent.predict(np.zeros(4))[0] == decision.action == decision.plan.actions[0]
    agent.set_think_ahead(0, limit=0)
    assert vars(agent.config)["think_limit"] == 0
    assert agent.decide(np.zeros(4)).plan is None
    with pytest.raises(ValueError, match="Expected think_ahead between 0 and 8"):
        agent.set_think_ahead(9)
    paper = AO2("CartPole-v1", "paper")
    before = paper.config
    paper.set_think_ahead(0, limit=0)
    assert paper.config == before
    with pytest.raises(ValueError, match="cannot think ahead"):
        paper.set_think_ahead(1)


def test_a_limit_of_time_holds_by_the_clock_of_the_machine():
    agent = quick(think_ahead=8, think_limit=1).learn(300)
    plan = agent.decide(np.zeros(4)).plan
    assert plan is not None
    assert 1 <= len(plan.actions) <= 8


def test_evaluation_starts_where_training_never_does():
    agent, resets = quick(toy_envs.Corridor()), []
    reset = agent.env.reset
    agent.env.reset = lambda seed: resets.append(seed) or reset(seed=seed)
    agent.learn(200)
    assert max(resets) < FIRST_EVALUATION_SEED
    resets.clear()
    agent.evaluate(5, seed=3)
    assert resets == [evaluation_seed(3, i) for i in range(5)]
    assert min(resets) >= FIRST_EVALUATION_SEED


def test_evaluation_repeats_and_other_seeds_differ():
    agent = quick().learn(300)
    assert agent.evaluate(5, seed=1).tolist() == agent.evaluate(5, seed=1).tolist()
    assert agent.evaluate(8, seed=1).tolist() != agent.evaluate(8, seed=2).tolist()
    starts = {evaluation_seed(s, i) for s in range(50) for i in range(100)}
    assert len(starts) == 5000


def test_recorded_episodes_are_greedy_and_explain_each_step():
    agent = quick().learn(500)
    episode = agent.record_episode(7)
    assert agent.episodes == [episode]
    assert episode.seed == 7
    assert not episode.is_training
    assert episode.started_at == agent.num_timesteps == 500
    assert len(episode.decisions) == len(episode) == len(episode.observations) - 1
    for observation, action, decision in zip(
        episode.observations[:-1], episode.actions, episode.decisions, strict=True
    ):
        assert np.array_equal(decision.observation, observation)
        assert decision.action == action == decision.best_action
        assert not decision.explored
    assert episode.terminated != episode.truncated


@pytest.mark.parametrize("env_id", [name for name in CATALOGUE if name != "LunarLander-v3"])
def test_one_setting_serves_all_tasks_but_for_the_levels_that_follow_from_the_features(env_id):
    agent = AO2(env_id)
    levels = {2: 5, 3: 4, 4: 3, 6: 2}[agent.spec.n_features]
    assert agent.config == AnticipatingConfig(levels=levels)


def test_settings_of_the_paper_come_first_and_overrides_win():
    assert AO2("CartPole-v1", attention_width=3.0, levels=2).config.attention_width == 3.0
    assert AO2("Pendulum-v1", "paper").config.trace_length == 18
    assert AO2("Pendulum-v1", action_bins=7).spec.n_actions == 7


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: AO2("CartPole-v1", gama=0.9), "'gama'.*mean 'gamma'.*Valid settings: action_bins"),
        (lambda: AO2("CartPole-v1", "paper", levels=2), "'levels' in the paper preset.*threshold"),
        (lambda: AO2("CartPole-v1", gamma=2), "gamma between 1e-06 and 1, but got 2"),
        (lambda: AO2("CartPole-v1", "clever"), "'paper' or 'anticipating', but got 'clever'"),
        (lambda: AO2("CartPole-v1", seed=-1), "seed to be a whole number.*got -1"),
        (lambda: AO2("CartPole-v1", seed=0.5), "seed to be a whole number.*got 0.5"),
        (lambda: AO2(42), "Gymnasium id or a single gymnasium.Env, but got int"),
        (lambda: AO2("FrozenLake-v1"), "one row of numbers"),
    ],
)  # fmt: skip
def test_what_cannot_be_made_says_why(make, words):
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.parametrize(
    ("env_id", "words"),
    [
        ("BadObservation-v0", "BadObservation-v0 gave feature 0 = nan"),
        ("BadReward-v0", "finite number as reward, but BadReward-v0 gave inf after 'action [01]'"),
        ("Exploding-v0", "the corridor exploded"),
    ],
)
def test_a_bad_environment_loses_nothing_that_was_learned(env_id, words):
    agent = quick(env_id, warmup_steps=5)
    with pytest.raises((ValueError, RuntimeError), match=words):
        agent.learn(500)
    learned, options = agent.num_timesteps, len(agent.forest.values)
    assert learned in (29, 59)
    assert options > 0
    agent.learn(20)
    assert agent.num_timesteps == learned + 20
    assert len(agent.forest.values) >= options


def test_environments_that_reuse_their_arrays_teach_the_same():
    class Copying(toy_envs.Corridor):
        def reset(self, **kwargs):
            observation, info = super().reset(**kwargs)
            return observation.copy(), info

        def step(self, action):
            observation, *rest = super().step(action)
            return observation.copy(), *rest

    assert same_forest(quick(toy_envs.Corridor()).learn(400), quick(Copying()).learn(400))


def test_stable_baselines_evaluates_it_unchanged():
    evaluation = pytest.importorskip("stable_baselines3.common.evaluation")
    vec_env = pytest.importorskip("stable_baselines3.common.env_util")
    for env_id, steps in (("CartPole-v1", 3000), ("Pendulum-v1", 400)):
        agent = AO2(env_id, seed=1).learn(steps)
        env = vec_env.make_vec_env(env_id, n_envs=3, seed=5)
        mean, _ = evaluation.evaluate_policy(agent, env, n_eval_episodes=6)
        alone, _ = evaluation.evaluate_policy(
            agent, gym.make(env_id), n_eval_episodes=4, warn=False
        )
        if env_id == "CartPole-v1":
            assert min(mean, alone) > 100, "A random policy earns about 20."


def test_importing_is_quick_and_light():
    heavy = "('viser', 'plotly', 'typer', 'rich', 'torch', 'networkx', 'PIL')"
    code = f"import sys, ao2viz; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_package_exports_what_it_documents():
    for name in ao2viz.__all__:
        assert hasattr(ao2viz, name)
    assert ao2viz.__version__ == "unknown" or ao2viz.__version__[0].isdigit()
    assert (
        repr(quick("Corridor-v0")) == "<AO2 anticipating on Corridor-v0: 0 options after 0 steps>"
    )
