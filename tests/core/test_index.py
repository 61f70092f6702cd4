"""Random histories ask the index whether it is sound, and the search whether it is exact."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import Forest
from ao2viz.core.index import BUCKET, check_index
from ao2viz.core.search import ANY_ACTION, find_nearest, kernel_width

seeds = st.integers(0, 2**32 - 1)


def uniform(rng, count, n_features):
    return rng.random((count, n_features))


def on_a_grid(rng, count, n_features):
    """Many equal points, and many equal distances between those that are not."""
    return rng.integers(-3, 4, (count, n_features)) / 2


def in_clusters(rng, count, n_features):
    centres = rng.normal(size=(3, n_features))
    return centres[rng.integers(3, size=count)] + rng.normal(size=(count, n_features)) * 1e-6


def on_a_line(rng, count, n_features):
    """In the order in which they lie: the worst for a tree that is not kept in balance."""
    along = np.sort(rng.random(count))
    return along[:, None] * rng.normal(size=n_features)


def all_alike(rng, count, n_features):
    return np.tile(rng.integers(-1, 2, n_features) / 2.0, (count, 1))


SHAPES = [uniform, on_a_grid, in_clusters, on_a_line, all_alike]


def search(forest, query, count, action=ANY_ACTION, limit=np.inf, radius=np.inf):
    ids, distances = np.empty(count, np.int64), np.empty(count)
    columns, query = forest.columns, forest.attention * query
    n = find_nearest(columns.places, columns.visits, query, action, limit, radius, ids, distances)
    return list(zip(distances[:n].tolist(), ids[:n].tolist(), strict=True))


def search_all(forest, query, count, action=ANY_ACTION, limit=np.inf, radius=np.inf):
    """Every living option measured, feature by feature in the same order; then sorted."""
    n, columns = forest.n_rows, forest.columns
    distances = np.zeros(n)
    for d in range(forest.n_features):
        distances += np.abs(columns.scaled[:n, d] - forest.attention[d] * query[d])
    counts = columns.is_alive[:n] & (distances <= limit)
    if action != ANY_ACTION:
        counts &= columns.visits[:n, action] > 0
    found = sorted((float(distances[n]), int(n)) for n in np.flatnonzero(counts))[:count]
    return [pair for pair in found if pair[0] <= kernel_width(found[0][0], radius)]


class IndexMachine(RuleBasedStateMachine):
    @initialize(n_features=st.integers(1, 8), seed=seeds)
    def plant(self, n_features, seed):
        self.rng = np.random.default_rng(seed)
        self.forest = Forest(n_features, 2, self.rng.uniform(0.1, 2.0, n_features))

    def living(self):
        return np.flatnonzero(self.forest.view().is_alive)

    @rule(shape=st.sampled_from(SHAPES), count=st.integers(1, 3 * BUCKET))
    def add(self, shape, count):
        for value in shape(self.rng, count, self.forest.n_features):
            option = self.forest.add(value, NO_OPTION, 0).option
            self.forest.columns.visits[option, 1] = self.rng.integers(2)

    @precondition(lambda self: len(self.living()))
    @rule(part=st.floats(0.0, 1.0))
    def cleanse(self, part):
        living = self.living()
        for option in self.rng.permutation(living)[: int(part * min(len(living), 60))]:
            self.forest.remove(int(option), 0)

    @rule(weightless=st.booleans())
    def attend(self, weightless):
        attention = self.rng.uniform(0.1, 2.0, self.forest.n_features)
        if weightless:
            attention[self.rng.integers(self.forest.n_features)] = 0.0
        self.forest.set_attention(attention, 0)

    @precondition(lambda self: len(self.living()))
    @rule()
    def regrow(self):
        _, alive = self.forest.begin_regrowth()
        for option in alive.tolist():
            if option != alive[0] and self.rng.random() < 0.2:
                self.forest.merge_away(option, int(alive[0]), 0)
            else:
                self.forest.replant(option, NO_OPTION)

    @rule()
    def reload(self):
        loaded = Forest(self.forest.n_features, 2, np.zeros(self.forest.n_features))
        loaded.set_state(self.forest.get_state())
        self.forest = loaded

    @rule(
        shape=st.sampled_from(SHAPES),
        count=st.integers(1, 20),
        action=st.sampled_from([ANY_ACTION, 1]),
        limit=st.sampled_from([np.inf, 1.0, 0.25, 0.0]),
        radius=st.sampled_from([np.inf, 0.1, 0.0]),
    )
    def ask(self, shape, count, action, limit, radius):
        queries = list(shape(self.rng, 4, self.forest.n_features))
        if self.forest.n_rows:
            queries.append(self.forest.columns.values[self.rng.integers(self.forest.n_rows)])
        for query in queries:
            asked = query, count, action, limit, radius
            assert search(self.forest, *asked) == search_all(self.forest, *asked)

    @invariant()
    def sound(self):
        if hasattr(self, "forest"):
            n, columns = self.forest.n_rows, self.forest.columns
            check_index(columns.places, columns.scaled[:n], columns.is_alive[:n])


TestIndexMachine = IndexMachine.TestCase
TestIndexMachine.settings = settings(max_examples=60, stateful_step_count=20, deadline=None)


def depth_of(index, node=0):
    if index.nodes["axis"][node] < 0:
        return 0
    child = int(index.nodes["below"][node])
    return 1 + max(depth_of(index, child), depth_of(index, child + 1))


@settings(max_examples=10, deadline=None)
@given(seed=seeds, n_features=st.integers(1, 8), shape=st.sampled_from(SHAPES))
def test_however_options_come_the_tree_stays_shallow(seed, n_features, shape):
    rng = np.random.default_rng(seed)
    forest = Forest(n_features, 1, np.ones(n_features))
    for value in shape(rng, 4000, n_features):
        forest.add(value, NO_OPTION, 0)
    # Halving every time would take 7 levels; 4,000 points on a line, never rebalanced, take 250.
    assert depth_of(forest.columns.places) <= 16 + 2 * n_features
    for query in shape(rng, 3, n_features):
        assert search(forest, query, 16) == search_all(forest, query, 16)


def test_options_that_are_all_alike_share_one_leaf():
    forest = Forest(2, 1, np.ones(2))
    for step in range(10 * BUCKET):
        forest.add(np.ones(2), NO_OPTION, step)
    assert depth_of(forest.columns.places) == 0
    assert [option for _, option in search(forest, np.zeros(2), 5)] == [0, 1, 2, 3, 4]
    forest.add(np.zeros(2), NO_OPTION, 0)
    for step in range(BUCKET):
        forest.add(np.array([0.0, step]), NO_OPTION, step)
    assert depth_of(forest.columns.places) > 0
    assert search(forest, np.ones(2), 400) == search_all(forest, np.ones(2), 400)


def test_an_empty_forest_has_nothing_near():
    assert search(Forest(3, 1, np.ones(3)), np.zeros(3), 4) == []


@pytest.mark.parametrize("column", ["counts", "boxes", "ids"])
def test_an_index_that_is_not_sound_says_so(column):
    forest = Forest(1, 1, np.ones(1))
    for step in range(2 * BUCKET):
        forest.add(np.array([float(step)]), NO_OPTION, step)
    index = forest.columns.places
    match column:
        case "counts":
            index.nodes["count"][0] += 1
        case "boxes":
            index.boxes[0, 0, 1] = 3.0
        case "ids":
            index.ids[0, 0] = 2 * BUCKET - 1
    with pytest.raises(AssertionError, match=r"miscounts|outside|its own|not equal"):
        forest.check_invariants()
