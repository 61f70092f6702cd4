"""Random histories ask the forest whether it is sound and its search exact."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import Forest
from ao2viz.core.growth import GrowthKind

N_FEATURES, N_ACTIONS = 3, 2
# Halves of small whole numbers: many equal distances, so that ties are really tested.
coordinates = st.integers(-8, 8).map(lambda n: n / 2)
points = st.lists(coordinates, min_size=N_FEATURES, max_size=N_FEATURES).map(np.array)
attentions = st.lists(st.sampled_from([0.0, 0.25, 1.0, 3.0]), min_size=3, max_size=3).map(np.array)


def nearest_by_brute_force(forest, observation, count, action=-1):
    """Every living option measured in plain Python, sorted by distance, then age."""
    query = forest.attention * observation
    found = []
    for option in range(forest.n_rows):
        tried = action < 0 or forest.columns.visits[option, action] > 0
        if forest.columns.is_alive[option] and tried:
            distance = 0.0
            for d in range(N_FEATURES):
                distance += abs(forest.columns.scaled[option, d] - query[d])
            found.append((distance, option))
    return sorted(found)[:count]


class ForestMachine(RuleBasedStateMachine):
    @initialize(attention=attentions)
    def plant(self, attention):
        self.forest = Forest(N_FEATURES, N_ACTIONS, attention)
        self.step = 0

    def living(self, data):
        return data.draw(st.sampled_from(np.flatnonzero(self.forest.view().is_alive).tolist()))

    @rule(value=points)
    def add_root(self, value):
        event = self.forest.add(value, NO_OPTION, self.step)
        assert event.kind is GrowthKind.CREATED
        assert event.option == self.forest.n_rows - 1

    @precondition(lambda self: len(self.forest.view()))
    @rule(value=points, data=st.data())
    def add_child(self, value, data):
        self.forest.add(value, self.living(data), self.step)

    @precondition(lambda self: len(self.forest.view()))
    @rule(data=st.data(), visits=st.integers(0, 2))
    def visit(self, data, visits):
        self.forest.columns.visits[self.living(data), 1] = visits

    @precondition(lambda self: len(self.forest.view()) > 1)
    @rule(data=st.data())
    def link(self, data):
        parent, child = self.living(data), self.living(data)
        view = self.forest.view()
        if parent != child and parent not in view.parents_of(child):
            self.forest.link(parent, child, self.step)
            assert parent in self.forest.view().parents_of(child)

    @precondition(lambda self: len(self.forest.view()))
    @rule(data=st.data())
    def cleanse(self, data):
        option = self.living(data)
        children = self.forest.view().children_of(option)
        parent = self.forest.view().parents[option]
        events = self.forest.remove(option, self.step)
        view = self.forest.view()
        assert not view.is_alive[option]
        assert (view.parents[children] == parent).all()
        moved = sorted(e.option for e in events if e.kind is GrowthKind.MOVED)
        assert moved == children.tolist()

    @rule(attention=attentions)
    def attend(self, attention):
        self.forest.set_attention(attention, self.step)

    @rule(query=points, count=st.integers(1, 6), action=st.sampled_from([-1, 1]))
    def search(self, query, count, action):
        ids, distances = self.forest.nearest(query, count, action)
        expected = nearest_by_brute_force(self.forest, query, count, action)
        assert list(zip(distances.tolist(), ids.tolist(), strict=True)) == expected

    @rule()
    def save_and_load(self):
        state = self.forest.get_state()
        loaded = Forest(N_FEATURES, N_ACTIONS, np.zeros(N_FEATURES))
        loaded.set_state(state)
        for name, array in loaded.get_state().items():
            np.testing.assert_array_equal(array, state[name], err_msg=name)
        self.forest = loaded

    @invariant()
    def sound(self):
        if hasattr(self, "forest"):
            self.forest.check_invariants()


TestForestMachine = ForestMachine.TestCase
TestForestMachine.settings = settings(max_examples=40, stateful_step_count=25, deadline=None)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 400))
def test_search_equals_brute_force_on_real_numbers(seed, n):
    rng = np.random.default_rng(seed)
    forest = Forest(N_FEATURES, N_ACTIONS, rng.uniform(0.1, 2, N_FEATURES))
    for i in range(n):
        parent = NO_OPTION if i == 0 or rng.random() < 0.1 else int(rng.integers(i))
        forest.add(rng.normal(size=N_FEATURES), parent, i)
    for query in rng.normal(size=(10, N_FEATURES)):
        ids, distances = forest.nearest(query, 16)
        expected = nearest_by_brute_force(forest, query, 16)
        assert list(zip(distances.tolist(), ids.tolist(), strict=True)) == expected


def forest_of_three():
    forest = Forest(N_FEATURES, N_ACTIONS, np.ones(N_FEATURES))
    forest.add(np.zeros(3), NO_OPTION, 0)
    forest.add(np.ones(3), 0, 1)
    forest.add(np.full(3, 2.0), 1, 2)
    return forest


def test_a_view_cannot_be_written_to_and_does_not_change_with_the_forest():
    forest = forest_of_three()
    view = forest.view()
    forest.remove(1, 3)
    assert view.is_alive.all()
    with pytest.raises(ValueError, match="read-only"):
        view.values[0] = 1.0


def test_a_path_leads_from_the_root_down():
    assert forest_of_three().view().path_to(2).tolist() == [0, 1, 2]


def test_removing_what_is_not_there_is_refused():
    forest = forest_of_three()
    forest.remove(1, 3)
    with pytest.raises(ValueError, match="no living option 1"):
        forest.remove(1, 4)


@pytest.mark.parametrize("weights", [[1, 1], [1, -1, 1], [1, np.nan, 1], [np.inf, 1, 1]])
def test_attention_that_is_no_attention_is_refused(weights):
    with pytest.raises(ValueError, match="3 finite attention weights"):
        forest_of_three().set_attention(np.array(weights), 0)


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("parents", [1, 0, 1], "cycle"),
        ("parents", [-1, 7, 1], "among the 3 options"),
        ("parents", [-2, 0, 1], "among the 3 options"),
        ("is_alive", [True, False, True], "living option"),
        ("visits", [[0, 0], [0, -1], [0, 0]], "visits of at least 0"),
        ("weights", [[0, 0], [0, np.nan], [0, 0]], "finite values and weights"),
        ("weights", [[0, 0, 0]] * 3, "shape"),
        ("links", [[0, 1]], "extra links"),
        ("links", [[0, 9]], "among the 3 options"),
        ("attention", [1, -1, 1], "attention weights"),
    ],
)
def test_a_state_that_is_no_forest_is_refused(name, change, message):
    state = forest_of_three().get_state()
    state[name] = np.array(change, state[name].dtype)
    with pytest.raises(ValueError, match=message):
        Forest(N_FEATURES, N_ACTIONS, np.ones(N_FEATURES)).set_state(state)


def test_a_state_with_an_array_missing_is_refused():
    state = forest_of_three().get_state()
    del state["born"]
    with pytest.raises(ValueError, match="Expected an array 'born'"):
        Forest(N_FEATURES, N_ACTIONS, np.ones(N_FEATURES)).set_state(state)
