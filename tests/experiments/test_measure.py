"""One run: evaluating along the way must not change what is learned."""

import json
import time

import pytest

from ao2viz import AO2, DecideBy, Preset
from ao2viz.experiments.measure import attempt, measure
from ao2viz.experiments.plan import Run, Schedule
from ao2viz.training.loop import evaluation_seed
from tests import toy_envs  # noqa: F401  Registers them.

QUICK = {"warmup_steps": 60}


def quick(env: str, preset: Preset = Preset.ANTICIPATING, **settings: object) -> Run:
    return Run(env, preset, json.dumps(settings), seed=3)


@pytest.mark.parametrize(
    "run",
    [
        quick("CartPole-v1", **QUICK),
        quick("Pendulum-v1", **QUICK, action_bins=3),
        quick("Acrobot-v1", **QUICK, story_length=40),
        quick("Pendulum-v1", **QUICK, action_smoothing=0.5, impression=0.1, max_depth=1),
        quick("CartPole-v1", Preset.PAPER),
        quick("Pendulum-v1", Preset.PAPER, decide_by="vote"),
        quick("Pendulum-v1", Preset.PAPER, action_smoothing=0.5, impression=0.1, max_depth=1),
    ],
    ids=str,
)
def test_every_checkpoint_is_as_if_learning_had_ended_there(run: Run) -> None:
    # Once within the warm-up, twice in the middle of an episode, and at the end.
    schedule = Schedule((40, 333, 700), episodes=3)
    found = list(measure(run, schedule))
    assert [(one.steps, one.decide_by) for one in found] == [
        (steps, way) for steps in schedule.checkpoints for way in DecideBy
    ]
    for one in found:
        agent = AO2(run.env, run.preset, run.seed, **run.overrides).learn(one.steps)
        agent.set_decide_by(one.decide_by)
        assert one.returns == tuple(agent.evaluate(3))
        assert one.options == len(agent.forest)


@pytest.mark.parametrize(
    "run",
    [quick("CartPole-v1", **QUICK), quick("Pendulum-v1", **QUICK, action_smoothing=0.5)],
    ids=str,
)
def test_the_decision_stack_is_the_path_behind_each_decision(run: Run) -> None:
    found = {one.decide_by: one for one in measure(run, Schedule((300,), episodes=2))}
    agent = AO2(run.env, run.preset, run.seed, **run.overrides).learn(300)
    agent.set_decide_by("path")
    lengths = [
        len(decision.path)
        for i in range(2)
        for decision in agent.record_episode(evaluation_seed(0, i)).decisions
    ]
    assert found[DecideBy.PATH].stack_mean == sum(lengths) / len(lengths)
    assert found[DecideBy.PATH].stack_most == max(lengths) > 1


def test_returns_are_summed_up_over_episodes() -> None:
    one, *_ = measure(quick("Corridor-v0", **QUICK), Schedule((100,), episodes=4))
    mean = sum(one.returns) / 4
    assert one.mean_return == mean
    spread = (sum((value - mean) ** 2 for value in one.returns) / 3) ** 0.5
    assert one.standard_error == pytest.approx(spread / 2)
    (single, _) = measure(quick("Corridor-v0", **QUICK), Schedule((100,), episodes=1))
    assert single.standard_error is None


def test_processor_time_grows_with_the_steps_and_leaves_out_evaluation() -> None:
    started = time.thread_time()
    found = list(measure(quick("CartPole-v1", **QUICK), Schedule((200, 400), episodes=20)))
    spent = time.thread_time() - started
    early, late = found[0].cpu_s, found[-1].cpu_s
    assert 0 < early < late < spent
    assert {one.cpu_s for one in found} == {early, late}


def test_a_run_that_fails_says_why_in_a_line() -> None:
    outcome = attempt(quick("Exploding-v0", **QUICK), Schedule((500,), episodes=1))
    assert outcome.evaluations == ()
    assert outcome.error == "RuntimeError: the corridor exploded"
