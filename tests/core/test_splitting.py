"""An option is split where its advice misleads: nearby, but on the other side of a choice."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ao2viz.core.accommodation import misleads
from ao2viz.core.config import Preset, make_config
from ao2viz.core.forest import Forest
from ao2viz.core.inference import make_workspace
from tests.core.test_learners import grown

RADIUS, RIDGE = 0.125, 0.02


def row_of_options(advantage):
    """Options along a line, a finest radius apart; the second action's advantage is given."""
    forest = Forest(1, 2, np.ones(1))
    for step, place in enumerate(np.arange(-8, 9) * RADIUS):
        option = forest.add(np.array([place]), -1, step).option
        forest.columns.weights[option] = 10.0, 10.0 + advantage(place)
    return forest


def asked(forest, place):
    """Whether the option nearest to a place misleads there."""
    query = np.array([place])
    nearest = int(forest.nearest(query)[0][0])
    work = make_workspace(16, 1)
    return misleads(forest.columns, query, nearest, RADIUS, RIDGE, work)


def test_an_option_misleads_beyond_the_place_where_the_choice_turns():
    # The choice turns at 0.03; the option at 0 prefers the first action, and so is right up to it.
    forest = row_of_options(lambda place: place - 0.03)
    assert not asked(forest, 0.0)
    assert not asked(forest, 0.02)
    assert asked(forest, 0.05)
    assert not asked(forest, 0.1)  # Nearest is the option at 0.125, on the right side.


def test_advice_that_costs_next_to_nothing_does_not_mislead():
    # At 0.05 the first action loses 0.0002 where 10 are expected: noise.
    assert not asked(row_of_options(lambda place: (place - 0.03) / 100), 0.05)


@given(st.floats(0.01, 100.0), st.floats(-0.9, 0.9))
def test_the_unit_of_the_reward_does_not_matter(unit, place):
    forest = row_of_options(lambda at: np.sin(5 * at))
    before = asked(forest, place)
    forest.columns.weights[: forest.n_rows] *= unit
    assert asked(forest, place) == before


def test_options_that_all_agree_are_never_split():
    forest = row_of_options(lambda _: 1.0)
    assert not any(asked(forest, place) for place in np.linspace(-1.0, 1.0, 101))


def test_a_learner_splits_within_the_finest_radius_and_only_if_told_to():
    whole = gaps_when_born(split_distance=1.0)
    split = gaps_when_born(split_distance=0.4)
    assert min(whole) > 1.0
    # Closer than a finest radius, but never closer than was asked for.
    assert 0.4 < min(split) < 1.0


def gaps_when_born(**settings):
    """Of every option, the distance to the nearest older one, in finest radii."""
    # Nothing regrows: attention stays as it was when the options were made.
    learner = grown(
        Preset.ANTICIPATING, 1500, attention_growth=1e6, attention_relevance=0.0, **settings
    )
    learner._forest.check_invariants()
    view = learner.view()
    scaled = view.values * view.attention
    radius = 0.5**learner.config.levels
    return [
        np.abs(scaled[option] - scaled[:option]).sum(axis=1).min() / radius
        for option in range(1, len(scaled))
    ]


def test_a_split_distance_past_the_radius_is_refused():
    with pytest.raises(ValueError, match="Expected split_distance between 0 and 1"):
        make_config(Preset.ANTICIPATING, {"split_distance": 1.5})
