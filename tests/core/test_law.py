"""Laws: what an action does in general is found exactly where there is a law, and never guessed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz import AO2
from ao2viz.core.config import Preset
from ao2viz.core.experience import (
    allocate_experience,
    expect_all,
    known_within,
    learn_law,
    predict,
    record,
)
from ao2viz.core.forest import Forest
from ao2viz.core.law import allocate_law, choose_terms, count_terms, write_terms
from ao2viz.core.local_linear import make_workspace
from tests.core.test_learners import grown, new_learner

RADIUS, RIDGE, CAP = 0.125, 0.01, 20


def cubic(rng, n_features):
    """A random polynomial of degree 3 from D numbers to D."""
    terms = [
        (rng.normal(size=n_features), rng.integers(0, n_features, degree))
        for degree in (0, 1, 1, 2, 2, 2, 3, 3, 3)
    ]
    return lambda x: sum(coefficient * np.prod(x[picked]) for coefficient, picked in terms)


class World:
    """Options strewn over a box, each of which tried action 0 once, somewhere near its value."""

    def __init__(self, moves, n_features, n_options, law_degree, seed=0):
        self.rng = np.random.default_rng(seed)
        self.forest = Forest(n_features, 1, np.ones(n_features))
        self.experience = allocate_experience(2048, 1, n_features, law_degree)
        self.work = make_workspace(32, n_features, 1)
        self.moves = moves
        for step in range(n_options):
            value = self.rng.uniform(-1, 1, n_features)
            option = self.forest.add(value, -1, step).option
            self.tries(option, value + self.rng.uniform(-0.02, 0.02, n_features))
        self.learn()

    def tries(self, option, before):
        after = before + self.moves(before)
        record(
            self.forest.columns.visits, self.experience, option, 0, before, after, 1.0, False, CAP
        )

    def learn(self):
        learn_law(self.forest.columns, self.experience, self.forest.n_rows, CAP)

    def predicts(self, state):
        """The displacement that is expected of the action at a state [D]."""
        known = predict(self.forest.columns, self.experience, state, 0, RADIUS, RIDGE, self.work)
        assert known
        return self.work.effect[: len(state)].copy()

    def error(self):
        """Mean distance between what is expected and what happens, at 200 states near options."""
        near = self.rng.integers(0, self.forest.n_rows, 200)
        gaps = self.rng.uniform(-0.1, 0.1, (200, self.forest.n_features))
        states = self.forest.columns.values[near] + gaps
        return np.mean([np.abs(self.predicts(s) - self.moves(s)).sum() for s in states])


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n_features=st.integers(1, 3))
def test_a_cubic_world_is_predicted_exactly_also_between_its_options(seed, n_features):
    moves = cubic(np.random.default_rng(seed), n_features)
    # Experience is kept as float32, and the ridge steadies the law a little.
    assert World(moves, n_features, 300, law_degree=3, seed=seed).error() < 2e-3


def test_a_world_without_a_law_is_predicted_better_with_one_all_the_same():
    def wavy(x):
        return np.array([np.sin(3 * x[0] + x[1]), np.cos(2 * x[1]) * x[0]])

    with_law, without = (World(wavy, 2, 150, law_degree=degree).error() for degree in (3, 0))
    assert with_law < 0.5 * without


def test_an_exception_stays_where_it_is():
    world = World(lambda x: np.array([0.1, 0.0]), 2, 400, law_degree=3)
    exception = np.array([0.5, 0.5])
    option = world.forest.add(exception, -1, 0).option
    record(
        world.forest.columns.visits,
        world.experience,
        option,
        0,
        exception,
        exception + np.array([0.1, 0.3]),
        1.0,
        False,
        CAP,
    )
    world.learn()
    assert world.predicts(exception)[1] > 0.1
    assert abs(world.predicts(np.array([-0.5, -0.5]))[1]) < 0.01


def test_a_law_says_nothing_of_places_where_nobody_was():
    world = World(lambda x: np.array([0.1]), 1, 300, law_degree=3)
    far = np.array([1.0 + 5 * RADIUS])
    columns, work = world.forest.columns, world.work
    assert not predict(columns, world.experience, far, 0, RADIUS, RIDGE, work)


def test_what_the_law_expects_follows_the_experience():
    world = World(cubic(np.random.default_rng(3), 2), 2, 200, law_degree=2)
    world.tries(7, np.array([0.3, -0.2]))
    kept = world.experience.expected.copy()
    expect_all(world.experience, world.forest.n_rows)
    np.testing.assert_array_equal(world.experience.expected, kept)
    assert kept.any()


def test_features_far_from_zero_are_no_harder():
    near = World(lambda x: 0.1 * x**2, 2, 300, law_degree=3).error()
    shift = np.array([1000.0, -500.0])
    world = World(lambda x: 0.1 * (x - shift) ** 2, 2, 0, law_degree=3)
    for step in range(300):
        value = shift + world.rng.uniform(-1, 1, 2)
        world.tries(world.forest.add(value, -1, step).option, value)
    world.learn()
    # Where it was tried is kept as float32, which has 6e-5 of room at 1,000.
    assert world.error() < near + 1e-3


@pytest.mark.parametrize(
    ("n_features", "room", "tried", "terms"),
    [(4, 35, 39, 0), (4, 35, 40, 5), (4, 35, 120, 15), (4, 35, 280, 35), (4, 15, 9999, 15)],
)
def test_a_law_has_no_more_terms_than_its_experience_is_enough_for(n_features, room, tried, terms):
    assert choose_terms(n_features, room, tried) == terms


def test_many_features_leave_room_for_a_lower_degree_only():
    assert allocate_law(2, 8, 3).coefficients.shape == (2, 165, 8)
    assert allocate_law(2, 24, 3).coefficients.shape == (2, count_terms(24, 2), 24)
    assert allocate_law(2, 4, 0).coefficients.size == 0


def test_the_terms_are_one_the_features_and_their_products():
    law = allocate_law(1, 2, 3)
    law.centre[:] = 1.0, 1.0
    write_terms(np.array([3.0, 4.0]), law, 10)
    assert law.terms.tolist() == [1, 2, 3, 4, 6, 9, 8, 12, 18, 27]


def test_an_agent_without_laws_keeps_none():
    state = grown(Preset.ANTICIPATING, law_degree=0).get_state()
    assert not [name for name in state if name.startswith("law")]
    assert grown(Preset.ANTICIPATING).get_state()["law_coefficients"].any()


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("law_coefficients", np.nan, "numbers of the laws to be finite"),
        ("law_n_terms", 4, "Expected laws of 0 or up to"),
        ("law_n_terms", 10**6, "Expected laws of 0 or up to"),
        ("law_n_terms", -5, "Expected laws of 0 or up to"),
    ],
)
def test_a_broken_law_is_refused(name, value, message):
    state = grown(Preset.ANTICIPATING).get_state()
    state[name][...] = value
    with pytest.raises(ValueError, match=message):
        new_learner(Preset.ANTICIPATING).set_state(state)


def test_cart_pole_moves_by_a_law():
    """Its equations of motion are smooth: the law alone says where the next step leads."""
    learner = AO2("CartPole-v1", seed=0).learn(3_000)._learner
    experience, columns = learner._experience, learner._forest.columns
    tried = columns.visits[: learner._forest.n_rows] > 0
    moved = experience.displacement[: len(tried)][tried]
    left_over = moved - experience.expected[: len(tried)][tried]
    assert np.abs(left_over).mean() < 0.1 * np.abs(moved).mean()


@pytest.mark.parametrize(
    ("n_features", "levels", "reach"),
    [
        (2, 5, 0.125),  # MountainCar-v0: four finest radii, less than 1/8 a feature.
        (4, 3, 0.5),  # CartPole-v1: 1/8 a feature, four finest radii as well.
        (6, 2, 0.75),  # Acrobot-v1: 1/8 a feature, three radii.
        (8, 1, 1.0),  # LunarLander-v3: 1/8 a feature, two radii.
        (1, 2, 0.5),  # An option knows its surroundings: never less than two radii.
        (8, 5, 0.125),  # Nor what it has not looked at: never more than four.
    ],
)
def test_an_action_is_known_near_where_it_was_tried_and_not_beyond(n_features, levels, reach):
    radius = 0.5**levels
    assert known_within(radius, n_features) == pytest.approx(reach)
    forest = Forest(n_features, 1, np.ones(n_features))
    forest.add(np.zeros(n_features), -1, 0)
    experience = allocate_experience(1, 1, n_features, 0)
    work = make_workspace(32, n_features, 1)
    here = np.zeros(n_features)
    record(forest.columns.visits, experience, 0, 0, here, here, 1.0, False, CAP)
    for far, known in ((0.99, 1), (1.01, 0)):
        state = np.full(n_features, far * reach / n_features)
        assert predict(forest.columns, experience, state, 0, radius, RIDGE, work) == known
