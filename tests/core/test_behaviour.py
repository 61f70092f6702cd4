"""The paper's behaviour experiments, in the mind of either preset: what each setting does."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.config import Preset
from ao2viz.core.growth import GrowthKind
from ao2viz.core.impression import Impression
from tests.core.test_learners import (
    PRESETS,
    RANGES,
    Valley,
    assert_same_mind,
    grown,
    live,
    new_learner,
)

ONES = np.ones(2)
numbers = st.floats(-1e308, 1e308)


@pytest.mark.parametrize("preset", PRESETS)
def test_left_alone_the_switches_change_nothing(preset):
    off = {"action_smoothing": 1.0, "impression": 0.0, "max_depth": 0}
    assert_same_mind(grown(preset, **off), grown(preset))


# Personal impression.


def test_impression_follows_equation_3_by_hand():
    impression = Impression(2, 0.1)
    impression.move(np.array([0.5, -0.5]), -3.0)  # The first reward: no average rises yet.
    np.testing.assert_allclose(impression.factors, [0.95, 1.05])
    impression.move(np.array([1.0, 0.0]), -1.0)  # Above the average of −3, which rises to −2.
    np.testing.assert_allclose(impression.factors, [1.05, 1.05])
    impression.move(np.array([0.0, 1.0]), -2.5)  # Below the average of −2.
    np.testing.assert_allclose(impression.factors, [1.05, 0.95])


def test_where_every_step_earns_the_same_the_average_never_rises():
    impression = Impression(1, 0.01)
    for _ in range(50):
        impression.move(np.ones(1), 0.1)
    np.testing.assert_allclose(impression.factors, 0.5)


@settings(deadline=None)
@given(st.lists(st.tuples(numbers, numbers, numbers), max_size=40), st.floats(1e-6, 1.0))
def test_impression_stays_within_its_bounds_and_is_restored_exactly(steps, strength):
    impression = Impression(2, strength)
    for first, second, reward in steps:
        impression.move(np.array([first, second]), reward)
    assert ((impression.factors >= 0.25) & (impression.factors <= 4.0)).all()
    other = Impression(2, strength)
    other.set_state(impression.get_state())
    for each in (impression, other):
        each.move(ONES, 1.0)
    np.testing.assert_array_equal(other.factors, impression.factors)


@pytest.mark.parametrize(
    "array", [[1.0, 5.0, 1.0, 0.0], [1.0, 1.0, -1.0, 0.0], [1.0, 1.0, 1.0, np.nan], [1.0]]
)
def test_an_impression_that_cannot_have_come_about_is_refused(array):
    impression = Impression(2, 0.1)
    with pytest.raises(ValueError, match=r"Expected (an impression|array 'impression')"):
        impression.set_state({"impression": np.array(array)})
    np.testing.assert_array_equal(impression.factors, ONES)


def test_in_the_paper_preset_attention_is_shifted_between_episodes_and_only_there():
    learner = new_learner(Preset.PAPER, impression=0.1)
    initial = 1.0 / (2 * RANGES)
    shifted, before = 0, initial
    for _, view, events in live(learner, Valley(0), 500):
        if any(event.kind is GrowthKind.ATTENTION for event in events):
            shifted += 1
        else:
            np.testing.assert_array_equal(view.attention, before)
        before = view.attention
        # What this step adds counts from the next episode on.
        assert ((view.attention >= initial / 4) & (view.attention <= initial * 4)).all()
    assert shifted >= 9, "Every episode but the first begins with a look at the attention."
    assert (np.abs(before / initial - 1.0) > 0.01).all()
    learner._forest.check_invariants()


def test_the_paper_preset_takes_its_steps_from_the_chosen_option_in_units_of_the_ranges():
    learner = new_learner(Preset.PAPER, impression=0.5)
    learner.start(np.zeros(2))
    learner.observe(learner.decide(), 0.0, np.array([0.04, 0.0]), False, False)
    decision = learner.decide()
    assert decision.voters[0] == 0, "Too near to the root for an option of its own."
    learner.observe(decision, 1.0, np.zeros(2), False, False)  # The average rises.
    learner.start(np.zeros(2))
    expected = 1.0 / (2 * RANGES) * (1.0 + 0.5 * np.array([0.04, 0.0]) / RANGES)
    np.testing.assert_allclose(learner.view().attention, expected)


def test_in_the_anticipating_preset_impression_multiplies_the_learned_attention():
    learner = new_learner(Preset.ANTICIPATING, impression=0.5, attention_relevance=0.0)
    checked = []
    for _, _, events in live(learner, Valley(0), 3000):
        if any(event.kind is GrowthKind.ATTENTION for event in events):
            checked.append(learner.view().attention / learner._spread_attention())
            learner._forest.check_invariants()
    np.testing.assert_array_equal(checked[0], ONES)  # The warm-up's attention comes before any.
    assert (np.abs(np.log(checked[-1])) > np.log(1.05)).any()
    assert all(((each >= 0.25) & (each <= 4.0)).all() for each in checked)


@pytest.mark.parametrize("steps", [61, 333])
@pytest.mark.parametrize("preset", PRESETS)
def test_impression_survives_saving_to_the_bit(preset, steps):
    stayed, world = new_learner(preset, impression=0.2), Valley(7)
    for _ in live(stayed, world, steps):
        pass
    loaded = new_learner(preset, seed=99, impression=0.2)
    loaded.set_state(stayed.get_state())
    loaded._rng.bit_generator.state = stayed._rng.bit_generator.state
    same_world = Valley(7)
    same_world.rng.bit_generator.state = world.rng.bit_generator.state
    same_world.episode = world.episode
    for learner, around in ((stayed, world), (loaded, same_world)):
        for _ in live(learner, around, 400):
            pass
    assert_same_mind(loaded, stayed)


# Hierarchy.


@settings(deadline=None, max_examples=12)
@given(seed=st.integers(0, 1000), depth=st.integers(1, 4), preset=st.sampled_from(PRESETS))
def test_a_flatter_forest_decides_and_learns_the_same(seed, depth, preset):
    # Similarity is measured to every option, wherever in the tree it is.
    deep, flat = new_learner(preset, seed), new_learner(preset, seed, max_depth=depth)
    both = zip(live(deep, Valley(seed), 300), live(flat, Valley(seed), 300), strict=True)
    for (decision, _, _), (other, view, _) in both:
        assert other.action == decision.action
        np.testing.assert_array_equal(other.voters, decision.voters)
        np.testing.assert_array_equal(other.action_values, decision.action_values)
        assert len(other.path) <= min(len(decision.path), depth + 1)
        assert view.depths.max(initial=0) <= depth
    flat._forest.check_invariants()
    np.testing.assert_array_equal(flat.view().values, deep.view().values)
    np.testing.assert_array_equal(flat.view().weights, deep.view().weights)


@pytest.mark.parametrize("preset", PRESETS)
def test_depth_1_is_flat_where_there_would_be_levels(preset):
    assert grown(preset, 1500).view().depths.max() > 1
    view = grown(preset, 1500, max_depth=1).view()
    assert view.depths.max() == 1
    if preset is Preset.PAPER:
        assert (view.parents[1:] == 0).all(), "Everything hangs from the one root."


# Exploration.


@pytest.mark.parametrize("preset", PRESETS)
def test_one_action_in_ten_is_drawn_at_random_while_learning_and_none_otherwise(preset):
    tenth = {
        Preset.PAPER: {"epsilon": 0.1},
        Preset.ANTICIPATING: {"epsilon_start": 0.1, "epsilon_end": 0.1},
    }[preset]
    learner = new_learner(preset, **tenth)
    decisions = [decision for decision, _, _ in live(learner, Valley(0), 3000)][100:]
    explored = [decision for decision in decisions if decision.explored]
    # 2,900 tosses: four standard deviations are 0.022.
    assert len(explored) / len(decisions) == pytest.approx(0.1, abs=0.022)
    # Any action may be drawn, the best one included.
    best = [decision.action == decision.best_action for decision in explored]
    assert 0.3 < np.mean(best) < 0.7
    assert not any(learner.decide(explore=False).explored for _ in range(200))
    assert not any(learner.decide_at(np.zeros(2)).explored for _ in range(200))


# Trace length.


def test_in_the_paper_preset_a_reward_reaches_as_many_steps_as_the_trace_is_long():
    for length in (1, 3, 5):
        learner = new_learner(
            Preset.PAPER, credit="accumulate", gamma=0.5, trace_length=length, threshold=1.0
        )
        learner.start(np.zeros(2))
        for n in range(1, 7):  # Each state is far from those before: an option of its own.
            observation = np.array([0.1 * n, 0.0])
            learner.observe(learner.decide(), 0.0, observation, False, False)
        learner.observe(learner.decide(), 8.0, np.zeros(2), False, False)
        earned = learner.view().weights.max(axis=1)
        credits = 8.0 * 0.5 ** np.arange(length)
        assert earned[earned > 0][::-1].tolist() == credits.tolist()


def test_in_the_anticipating_preset_as_many_options_are_renewed_as_the_trace_is_long():
    def renewed(length):
        """How many options' weights each step changes, once there are options enough."""
        learner = new_learner(
            Preset.ANTICIPATING,
            trace_length=length,
            refreshes=0,
            backups=0,
            attention_growth=100.0,
            levels=5,
        )
        changed = []
        for step in live(learner, Valley(0), 900):
            now, before = learner.view().weights, step[1].weights
            known = len(before)
            changed.append(int((now[:known] != before).any(axis=1).sum()))
        return np.array(changed[300:])

    counts = {length: renewed(length) for length in (1, 4, 20)}
    for length, changed in counts.items():
        assert changed.max() <= length
    assert counts[1].mean() < counts[4].mean() < counts[20].mean()
