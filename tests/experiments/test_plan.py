"""What a sweep would do, told and checked before it does anything."""

import pytest

from ao2viz.core.config import Preset
from ao2viz.experiments.plan import make_runs, make_schedule

OURS = Preset.ANTICIPATING


def test_every_environment_meets_every_setting_and_every_seed():
    grid = {"levels": [3, 4], "gamma": [0.99, 0.995]}
    runs = make_runs(["CartPole-v1", "Pendulum-v1"], OURS, grid, range(3))
    assert len(runs) == len(set(runs)) == 2 * 4 * 3
    assert [run.seed for run in runs] == sorted(run.seed for run in runs)
    assert runs[1].overrides == {"levels": 3, "gamma": 0.995}
    assert str(runs[0]) == "CartPole-v1 anticipating gamma=0.99 levels=3 seed 0"


def test_without_settings_there_is_one_run_a_seed():
    (run,) = make_runs(["CartPole-v1"], Preset.PAPER, {}, [7])
    assert run.settings == "{}"
    assert str(run) == "CartPole-v1 paper seed 7"


def test_what_means_the_same_is_run_once():
    grid = {"levels": [3, 3.0], "gamma": [1, 1.0], "decide_by": ["path"]}
    (run,) = make_runs(["CartPole-v1", "CartPole-v1"], OURS, grid, [0])
    assert run.settings == '{"decide_by": "path", "gamma": 1.0, "levels": 3}'


def test_how_finely_actions_are_told_apart_is_a_setting_too():
    runs = make_runs(["Pendulum-v1"], OURS, {"action_bins": [3, 5]}, [0])
    assert [run.overrides for run in runs] == [{"action_bins": 3}, {"action_bins": 5}]


@pytest.mark.parametrize(
    ("envs", "grid", "seeds", "words"),
    [
        (["CartPol-v1"], {}, [0], "CartPole-v1"),
        (["CartPole-v1", "Blackjack-v1"], {}, [0], "one-dimensional Box"),
        (["CartPole-v1"], {"lvels": [3]}, [0], "Did you mean 'levels'"),
        (["CartPole-v1"], {"levels": [3, 99]}, [0], "levels between 0 and 12, but got 99"),
        (["CartPole-v1"], {"levels": []}, [0], "1 to 100,000 runs, but these are 0"),
        (["CartPole-v1"], {}, [], "these are 0"),
        (["CartPole-v1"], {}, range(100_001), "these are 100,001"),
        (["CartPole-v1"], {}, [0, -1], "seeds from 0 on, but got -1 to 0"),
    ],
)  # fmt: skip
def test_what_cannot_be_run_is_refused(envs, grid, seeds, words):
    with pytest.raises(ValueError, match=words):
        make_runs(envs, OURS, grid, seeds)


def test_a_schedule_is_in_order_and_ends_with_its_last_step():
    assert make_schedule(100, [50, 20, 50], 3).checkpoints == (20, 50, 100)
    assert make_schedule(100, [100], 3).checkpoints == (100,)
    assert make_schedule(100, [], 3).checkpoints == (100,)


@pytest.mark.parametrize(
    ("steps", "checkpoints", "episodes", "words"),
    [
        (0, [], 1, "at least 1 as steps, but got 0"),
        (10, [], 0, "at least 1 as episodes, but got 0"),
        (10, [11], 1, r"checkpoints from 1 to 10 \(--steps\), but got 11"),
        (10, [0, 5], 1, "but got 0"),
    ],
)
def test_a_schedule_that_cannot_be_kept_is_refused(steps, checkpoints, episodes, words):
    with pytest.raises(ValueError, match=words):
        make_schedule(steps, checkpoints, episodes)
