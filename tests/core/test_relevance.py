"""Attention goes to the features that the choice between the actions depends on."""

import numpy as np
import pytest

from ao2viz.core.attention import has_changed
from ao2viz.core.forest import Forest
from ao2viz.core.relevance import find_relevance


def grown_forest(advantage, n=300, units=(1.0, 1.0, 1.0), seed=0):
    """Options scattered in a cube; the second action's weight exceeds the first by `advantage`."""
    places = np.random.default_rng(seed).uniform(-1.0, 1.0, (n, 3))
    forest = Forest(3, 2, np.ones(3))
    forest.reserve(n)
    for step, place in enumerate(places):
        option = forest.add(place * units, -1, step).option
        forest.columns.weights[option] = 50.0, 50.0 + advantage(place)
        forest.columns.visits[option] = 1
    return forest


def relevance_of(forest, attention=(1.0, 1.0, 1.0)):
    return find_relevance(forest, np.ones((forest.n_rows, 2), np.int32), np.array(attention))


def test_a_feature_counts_by_how_steeply_the_advantage_changes_along_it():
    found = relevance_of(grown_forest(lambda place: 2.0 * place[0] + 1.0 * place[1]))
    assert found[0] / found[1] == pytest.approx(2.0, rel=0.05)
    assert found[2] == found.min()
    np.testing.assert_array_less(0.249, found)
    np.testing.assert_array_less(found, 4.001)


def test_what_all_actions_share_does_not_count():
    def add_value(forest):
        forest.columns.weights[: forest.n_rows] += 40.0 * forest.columns.values[:300, 2:3]
        return forest

    plain = grown_forest(lambda place: place[0] + 0.5 * place[1] + 0.2 * place[2])
    before = relevance_of(plain)
    np.testing.assert_allclose(relevance_of(add_value(plain)), before, rtol=1e-9)


def test_units_do_not_matter():
    def advantage(place):
        return place[0] + 0.5 * place[1] + 0.25 * place[2]

    units = np.array([1e-3, 1.0, 500.0])
    plain = relevance_of(grown_forest(advantage))
    other = relevance_of(grown_forest(advantage, units=units), 1.0 / units)
    np.testing.assert_allclose(other, plain, rtol=1e-6)


def test_too_little_known_changes_nothing():
    forest = grown_forest(lambda place: place[0])
    steps = np.ones((forest.n_rows, 2), np.int32)
    steps[20:, 1] = 0  # Most options know of one action only.
    np.testing.assert_array_equal(find_relevance(forest, steps, np.ones(3)), np.ones(3))


def test_a_flat_choice_or_a_feature_that_never_varied_changes_nothing():
    flat = grown_forest(lambda place: 0.0)
    np.testing.assert_array_equal(relevance_of(flat), np.ones(3))
    still = grown_forest(lambda place: place[0] + 0.5 * place[1], units=(1.0, 1.0, 0.0))
    found = relevance_of(still, (1.0, 1.0, 0.0))
    assert found[2] == 1.0
    assert found[0] / found[1] == pytest.approx(2.0, rel=0.05)


def test_options_in_one_place_are_no_slope():
    forest = grown_forest(lambda place: place[0], units=(0.0, 0.0, 0.0))
    np.testing.assert_array_equal(relevance_of(forest), np.ones(3))


@pytest.mark.parametrize(
    ("old", "new", "changed"),
    [
        ((1.0, 2.0), (1.1, 2.2), False),
        ((1.0, 2.0), (1.0, 2.4), True),
        ((1.0, 2.0), (1.0, 1.7), True),
        ((1.0, 0.0), (1.0, 0.0), False),
        ((1.0, 0.0), (1.0, 1e-9), True),
        ((1.0, 1.0), (1.0, 0.0), True),
    ],
)
def test_attention_has_changed_if_any_feature_counts_much_more_or_less(old, new, changed):
    assert has_changed(np.array(old), np.array(new), 1.15) is changed
