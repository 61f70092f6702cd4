"""What `ao2viz paper` would run."""

import json

import pytest

from ao2viz import AO2
from ao2viz.baselines.algorithm import Algorithm
from ao2viz.baselines.zoo import steps_per_update
from ao2viz.core.config import Preset
from ao2viz.paper.plan import FIRST_SEED, FULL, QUICK, make_tasks, only, seconds
from ao2viz.paper.published import ENVS, TABLE_II, TITLES


@pytest.mark.parametrize("extent", [FULL, QUICK])
def test_everybody_meets_every_task_that_suits_them(extent):
    tasks = make_tasks(extent, 2, 1)
    runs = [task.run for task in tasks]
    assert len(set(runs)) == len(runs)
    for learner in TITLES:
        envs = {run.env for run in runs if run.preset is learner and run.settings == "{}"}
        odd = {Algorithm.SB3_SAC: {ENVS[1]}, Algorithm.SB3_QRDQN: {ENVS[0], ENVS[2]}}
        assert envs == odd.get(learner, set(ENVS))
        seeds = {run.seed - FIRST_SEED for run in runs if run.preset is learner}
        assert seeds == ({0, 1} if isinstance(learner, Preset) else {0})
    assert set(TABLE_II) <= set(TITLES)


def test_every_checkpoint_is_the_end_of_an_update():
    for task in [*make_tasks(FULL, 1, 1), *make_tasks(QUICK, 1, 1)]:
        run, marks = task.run, task.schedule.checkpoints
        assert list(marks) == sorted(set(marks))
        if isinstance(run.preset, Algorithm):
            unit = steps_per_update(run.preset, run.env)
            assert all(mark % unit == 0 for mark in marks), run


def test_the_quick_one_takes_less_than_fifteen_minutes_on_two_cores():
    tasks = make_tasks(QUICK, QUICK.seeds, QUICK.rival_seeds)
    assert sum(map(seconds, tasks)) < 2 * 15 * 60
    longest = max(map(seconds, tasks))
    assert longest < 5 * 60


def test_the_behaviour_experiments_are_settings_that_exist():
    settings = {task.run.settings for task in make_tasks(QUICK, 1, 0)} - {"{}"}
    assert len(settings) == 5
    for one in settings:
        AO2("Pendulum-v1", Preset.PAPER, **json.loads(one)).env.close()


def test_a_piece_can_be_named():
    tasks = make_tasks(QUICK, 2, 1)
    piece = only(tasks, ["ppo", "dac+ppo", "Acrobot-v1"])
    assert [(task.run.preset.value, task.run.env) for task in piece] == [
        ("dac+ppo", "Acrobot-v1"), ("ppo", "Acrobot-v1"),
    ]  # fmt: skip
    assert only(tasks, []) == tasks
    with pytest.raises(ValueError, match=r"one of paper, anticipating.*but got 'dqn'"):
        only(tasks, ["dqn"])
