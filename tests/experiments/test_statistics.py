"""Interquartile means and their intervals, on numbers small enough to check by hand."""

import numpy as np
import pytest

from ao2viz import DecideBy
from ao2viz.experiments.statistics import interquartile_mean, iqm_interval, summarise
from tests.experiments.evaluations import both_ways, evaluation, run


@pytest.mark.parametrize(
    ("scores", "expected"),
    [
        ([5.0], 5.0),
        ([0.0, 10.0], 5.0),
        ([0.0, 1.0, 5.0], 2.0),  # Three quarters of a score are none: nothing is cut off.
        ([-100.0, 1.0, 3.0, 100.0], 2.0),
        ([7.0, -1000.0, 8.0, 9.0, 1000.0], 8.0),
        ([0, 0, 1, 2, 3, 4, 1000, 1000.0], 2.5),
    ],
)
def test_the_middle_half_is_averaged(scores, expected):
    assert interquartile_mean(np.array(scores)) == expected


def test_an_interval_needs_two_seeds_and_repeats():
    assert iqm_interval(np.array([3.0])) is None
    assert iqm_interval(np.array([3.0, 3.0, 3.0])) == (3.0, 3.0)
    scores = np.arange(10.0)
    assert iqm_interval(scores) == iqm_interval(scores)


def test_two_seeds_leave_everything_between_them_open():
    # Of two scores, a quarter of the resamples is twice the lower one, a quarter twice the upper.
    assert iqm_interval(np.array([0.0, 8.0])) == (0.0, 8.0)


def test_an_interval_is_that_of_every_possible_resample():
    scores = np.array([0.0, 1.0, 2.0, 3.0])
    every = np.stack(np.meshgrid(*[scores] * 4), axis=-1).reshape(-1, 4)
    exact = np.quantile(np.sort(every)[:, 1:3].mean(axis=1), [0.025, 0.975])
    found = iqm_interval(scores)
    assert found is not None
    np.testing.assert_allclose(found, exact, atol=0.01)


def test_an_interval_holds_the_truth_about_as_often_as_it_claims():
    rng = np.random.default_rng(0)
    held = 0
    for _ in range(40):
        low, high = iqm_interval(rng.normal(size=20)) or (1.0, 0.0)
        held += low <= 0.0 <= high
    assert held >= 34


def test_seeds_are_grouped_by_all_that_tells_runs_apart():
    rows = [
        *both_ways(1.0, 3.0, of=run(1)),
        *both_ways(5.0, 7.0, of=run(0)),
        *both_ways(9.0, of=run(0, gamma=0.995)),
        *both_ways(9.0, of=run(0, gamma=0.99)),
        *both_ways(9.0, of=run(0), steps=500),
        *both_ways(9.0, of=run(0, env="Acrobot-v1")),
    ]
    found = summarise(rows)
    assert [(one.env, one.settings, one.steps) for one in found[::2]] == [
        ("Acrobot-v1", "{}", 1000),
        ("CartPole-v1", "{}", 500),
        ("CartPole-v1", "{}", 1000),
        ("CartPole-v1", '{"gamma": 0.99}', 1000),
        ("CartPole-v1", '{"gamma": 0.995}', 1000),
    ]
    several = found[5]
    assert several.decide_by is DecideBy.VOTE
    assert [one.run.seed for one in several.evaluations] == [0, 1]
    assert several.means.tolist() == [6.0, 2.0]
    assert several.iqm == 4.0
    assert several.interval == (2.0, 6.0)
    assert (several.options, several.stack_mean, several.stack_most) == (500, 3.25, 5)
    assert several.cpu_s == 1.5


def test_numbers_and_words_can_be_values_of_one_setting():
    rows = [evaluation(of=run(0, x=value)) for value in ("b", 2, 1.5, "a")]
    assert [one.settings for one in summarise(rows)] == [
        '{"x": 1.5}', '{"x": 2}', '{"x": "a"}', '{"x": "b"}',
    ]  # fmt: skip
