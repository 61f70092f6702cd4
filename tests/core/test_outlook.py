"""One option decides by its outlook: its weights, evened out and followed to what is seen."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.decision import DecideBy
from ao2viz.core.forest import Forest
from ao2viz.core.inference import Reading, act, decide, find_shares
from ao2viz.core.local_linear import make_workspace

RIDGE = 1e-6


def plane(place, slope=(2.0, -1.0)):
    return 10.0 + np.asarray(place) @ np.asarray(slope)


def grid_of_options(weight, step=0.25, errors=None):
    """Options on a grid over [-1, 1]²; the first action earns `weight(value)`, the second 10."""
    forest = Forest(2, 2, np.array([1.0, 1.2]))
    axis = np.arange(-1.0, 1.0 + step / 2, step)
    for n, value in enumerate(np.array(np.meshgrid(axis, axis)).reshape(2, -1).T):
        option = forest.add(value, -1, n).option
        forest.columns.weights[option] = weight(value), 10.0
        if errors is not None:
            forest.columns.weights[option, 0] += errors[n]
    return forest


def asked(forest, place, decide_by=DecideBy.PATH, has_outlook=True, ridge=RIDGE):
    reading = Reading(decide_by, ridge, has_outlook)
    return decide(forest, np.asarray(place, float), reading, make_workspace(32, 2, 2))


@settings(deadline=None)  # The first call compiles.
@given(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9))
def test_where_weights_lie_on_a_plane_one_option_knows_it_everywhere(x, y):
    decision = asked(grid_of_options(plane), (x, y))
    assert len(decision.voters) == 1
    np.testing.assert_allclose(decision.action_values, [plane((x, y)), 10.0], rtol=1e-4)
    np.testing.assert_allclose(decision.slopes, [[2.0, -1.0], [0.0, 0.0]], atol=1e-3)


def test_the_choice_turns_where_it_turns_and_not_where_the_options_border_on_each_other():
    forest = grid_of_options(lambda value: 10.0 + value[0] - 0.03)
    # Both are nearest to the option at 0, whose own weights prefer the second action.
    assert asked(forest, (0.02, 0.0)).action == 1
    assert asked(forest, (0.05, 0.0)).action == 0
    assert asked(forest, (0.05, 0.0), has_outlook=False).action == 1


def test_neighbours_even_out_the_error_of_a_single_option():
    n = 81
    errors = np.random.default_rng(0).normal(0.0, 1.0, n)
    forest = grid_of_options(plane, errors=errors)
    places = np.random.default_rng(1).uniform(-0.9, 0.9, (200, 2))
    with_it, without = (
        np.mean([abs(asked(forest, p, has_outlook=o).action_values[0] - plane(p)) for p in places])
        for o in (True, False)
    )
    assert with_it < 0.7 * without


def test_without_an_outlook_the_options_own_weights_decide():
    forest = grid_of_options(plane)
    decision = asked(forest, (0.1, 0.1), has_outlook=False)
    np.testing.assert_array_equal(
        decision.action_values, forest.columns.weights[decision.voters[0]]
    )
    assert not decision.slopes.any()


@pytest.mark.parametrize("is_deciding", [True, False])
@pytest.mark.parametrize("attention", [0.001, 1.0, 1000.0])
def test_who_has_a_say_does_not_depend_on_how_dense_the_options_lie(is_deciding, attention):
    rng = np.random.default_rng(3)
    values, place = rng.uniform(-1.0, 1.0, (200, 2)), np.array([0.1, -0.2])
    shares = []
    for scale in (1.0, attention):
        forest = Forest(2, 2, np.full(2, scale))
        for n, value in enumerate(values):
            forest.add(value, -1, n)
        work = make_workspace(32, 2, 2)
        count = find_shares(forest.columns, scale * place, 0.02, is_deciding, work)
        shares.append(dict(zip(work.ids[:count].tolist(), work.shares[:count], strict=True)))
    said, again = shares
    assert said.keys() == again.keys()
    np.testing.assert_allclose(list(said.values()), list(again.values()), atol=1e-9)
    # Three for each coefficient of a plane to decide, two to imagine; one more marks the width.
    assert len(said) == (10 if is_deciding else 7)
    assert sum(share > 0 for share in said.values()) > 3


@pytest.mark.parametrize("decide_by", list(DecideBy))
@pytest.mark.parametrize("n_options", range(4))
def test_few_options_are_enough(n_options, decide_by):
    forest = Forest(2, 2, np.ones(2))
    for n in range(n_options):
        forest.add(np.array([n, 0.0]), -1, n)
        forest.columns.weights[n] = n, 1.0
    decision = asked(forest, (0.2, 0.3), decide_by, ridge=0.02)
    assert np.isfinite(decision.action_values).all()
    assert np.isfinite(decision.slopes).all()
    assert len(decision.voters) == (min(n_options, 1) if decide_by is DecideBy.PATH else n_options)


@pytest.mark.parametrize("decide_by", list(DecideBy))
def test_options_that_all_lie_in_one_place_can_decide(decide_by):
    forest = Forest(2, 2, np.zeros(2))
    for n in range(40):
        forest.add(np.array([n, n]), -1, n)
        forest.columns.weights[n] = 1.0, 2.0
    decision = asked(forest, (5.0, 5.0), decide_by, ridge=0.02)
    np.testing.assert_allclose(decision.action_values, [1.0, 2.0])


@settings(deadline=None)  # The first call compiles.
@given(st.integers(0, 10_000), st.floats(0.01, 100.0))
def test_the_unit_of_the_reward_does_not_matter(seed, unit):
    rng = np.random.default_rng(seed)
    forest = grid_of_options(lambda _: rng.normal(10.0, 1.0), step=0.5)
    place = rng.uniform(-1.0, 1.0, 2)
    before = asked(forest, place)
    forest.columns.weights[: forest.n_rows] *= unit
    after = asked(forest, place)
    np.testing.assert_allclose(after.action_values, unit * before.action_values, rtol=1e-9)


def test_acting_gives_the_action_of_the_decision():
    forest = grid_of_options(lambda value: 10.0 + np.sin(7 * value[0]) * value[1])
    work = make_workspace(32, 2, 2)
    for place in np.random.default_rng(2).uniform(-1.0, 1.0, (300, 2)):
        for decide_by in DecideBy:
            reading = Reading(decide_by, 0.02, has_outlook=True)
            assert act(forest, place, reading, work) == decide(forest, place, reading, work).action


def test_a_toss_falls_alike_for_zero_with_either_sign():
    forest = Forest(2, 64, np.ones(2))
    forest.add(np.zeros(2), -1, 0)
    reading, work = Reading(DecideBy.PATH, RIDGE, True), make_workspace(32, 2, 64)
    actions = {
        decide(forest, np.array([x, y]), reading, work).action
        for x in (0.0, -0.0)
        for y in (0.0, -0.0)
    }
    assert len(actions) == 1
