"""Cleansing: what goes is not missed, and nothing goes that was not planned."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz import AO2, GrowthKind, Preset
from ao2viz.core.cleansing import apply_cleansing, plan_cleansing
from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import NO_OPTION, DecideBy
from ao2viz.core.experience import known_within
from ao2viz.core.forest import Forest
from ao2viz.core.imagination import rules_of
from ao2viz.core.inference import Reading, decide
from ao2viz.core.local_linear import make_workspace
from ao2viz.core.memory import Memory, allocate_memory, memory_to_arrays
from ao2viz.resources import saved_schemas

CONFIG = AnticipatingConfig(levels=5)
RULES = rules_of(CONFIG)
READING = Reading(DecideBy.PATH, CONFIG.share_ridge, has_outlook=True)


def grown(values, weights, visits, parents=None) -> Memory:
    """A memory of options at these scaled places, each of which met with something."""
    n_features, n_actions = values.shape[1], weights.shape[1]
    forest = Forest(n_features, n_actions, np.ones(n_features))
    for n, value in enumerate(values):
        forest.add(value, NO_OPTION if parents is None else int(parents[n]), step=n)
    forest.columns.weights[: len(values)] = weights
    forest.columns.visits[: len(values)] = visits
    memory = allocate_memory(forest, ends=7)
    memory.experience.reward[: len(values)] = weights
    return memory


def random_memory(seed: int, n: int, roughness: float) -> Memory:
    """Options a radius apart or more, whose weights follow a smooth slope, but for noise."""
    rng = np.random.default_rng(seed)
    values = []
    while len(values) < n:
        place = 6 * RULES.radius * rng.uniform(-1, 1, 2)
        if all(np.abs(place - other).sum() > RULES.radius for other in values):
            values.append(place)
        elif rng.random() < 0.02:
            break
    values = np.array(values)
    weights = np.stack([values[:, 0], 8 * values[:, 1] ** 2, values.sum(axis=1) - 0.1], axis=1)
    weights += roughness * rng.normal(size=weights.shape)
    visits = rng.integers(0, 3, weights.shape) * (rng.random(weights.shape) < 0.6)
    parents = [rng.integers(-1, n) if n else NO_OPTION for n in range(len(values))]
    return grown(values, weights, visits, parents)


def plan_for(memory: Memory, tolerance: float):
    work = make_workspace(CONFIG.voters, memory.forest.n_features, memory.forest.n_actions)
    return plan_cleansing(memory.forest, tolerance, RULES, work), work


def what_is_known(forest: Forest, values: np.ndarray) -> np.ndarray:
    """[N, A] whether an option that tried the action is within reach of each value."""
    view = forest.view()
    known = np.zeros((len(values), forest.n_actions), np.bool_)
    for n, value in enumerate(values):
        near = view.distances_to(value) <= known_within(RULES.radius, forest.n_features)
        known[n] = view.visits[near].any(axis=0)
    return known


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(0, 60),
    roughness=st.sampled_from([0.0, 0.02, 0.3]),
    tolerance=st.sampled_from([0.0, 0.01, 0.1, 1.0]),
)
def test_it_decides_knows_and_has_met_with_the_same_afterwards(seed, n, roughness, tolerance):
    memory = random_memory(seed, n, roughness) if n else grown(*[np.zeros((0, 2))] * 3)
    forest = memory.forest
    before, values = forest.view(), forest.view().values
    arrays = memory_to_arrays(memory)
    plan, work = plan_for(memory, tolerance)
    for name, array in memory_to_arrays(memory).items():
        np.testing.assert_array_equal(array, arrays[name], err_msg=f"Planning changed {name}.")
    forest.check_invariants()
    expected = [decide(forest, value, READING, work) for value in values]
    known = what_is_known(forest, values)

    events = apply_cleansing(memory, plan, CONFIG.experience_cap, step=99)

    forest.check_invariants()
    after = forest.view()
    assert len(after) == len(before) - len(plan)
    assert after.is_alive[plan.heirs].all()
    removed = [(e.option, e.parent) for e in events if e.kind is GrowthKind.REMOVED]
    assert removed == list(zip(plan.options.tolist(), plan.heirs.tolist(), strict=True))
    np.testing.assert_array_equal(
        after.visits[after.is_alive].sum(axis=0), before.visits.sum(axis=0)
    )
    for value, old in zip(values, expected, strict=True):
        new = decide(forest, value, READING, work)
        assert new.best_action == old.best_action
        np.testing.assert_allclose(
            new.action_values, old.action_values, rtol=0, atol=plan.slack + 1e-12
        )
    assert not (known & ~what_is_known(forest, values)).any()


def line_of_options(n: int, **changes) -> Memory:
    """Options 1.25 radii apart on a line, along which both actions earn more; the first is better.

    Each was visited twice by each action.
    """
    values = np.arange(n)[:, None] * 1.25 * RULES.radius
    weights = np.hstack([values, values - 1.0])
    visits = changes.get("visits", np.full((n, 2), 2))
    return grown(values, changes.get("weights", weights), visits)


def test_on_a_line_two_of_three_go_and_the_one_between_stands_for_them():
    plan, _ = plan_for(line_of_options(9), tolerance=0.5)
    # 0 goes to 1, which so stays; 2 to 1 as well; 3 to 4, 5 to 4, 6 to 7, 8 to 7.
    assert plan.options.tolist() == [0, 2, 3, 5, 6, 8]
    assert plan.heirs.tolist() == [1, 1, 4, 4, 7, 7]


def test_the_least_visited_go_first():
    visits = np.full((9, 2), 5)
    visits[[1, 4, 7]] = 1
    plan, _ = plan_for(line_of_options(9, visits=visits), tolerance=0.5)
    assert set(plan.options.tolist()) >= {1, 4, 7}


def test_an_heir_gets_the_mean_of_what_both_met_with_by_visits():
    memory = line_of_options(9)
    memory.experience.reward[0] = 10.0
    memory.experience.reward[1] = 1.0
    memory.experience.reward[2] = 4.0
    plan, _ = plan_for(memory, tolerance=0.5)
    apply_cleansing(memory, plan, CONFIG.experience_cap, step=0)
    np.testing.assert_allclose(memory.experience.reward[1], (10.0 + 1.0 + 4.0) / 3.0)
    assert memory.forest.view().visits[1].tolist() == [6, 6]


def test_who_decides_otherwise_than_all_around_stays():
    weights = np.tile([1.0, 0.0], (9, 1))
    weights[:, 0] += np.arange(9) / 100  # So that there is a spread to measure by.
    weights[4] = [0.0, 9.0]
    plan, _ = plan_for(line_of_options(9, weights=weights), tolerance=0.05)
    assert 4 not in plan.options


def test_who_alone_knows_of_an_action_far_away_stays():
    visits = np.full((4, 2), 1)
    visits[1:, 1] = 0
    # Option 3 knows of action 1 only through option 0, 3.75 radii away.
    assert 0 not in plan_for(line_of_options(4, visits=visits), tolerance=1.0)[0].options
    assert 0 in plan_for(line_of_options(4, visits=visits * 0 + 1), tolerance=1.0)[0].options


def test_a_child_moves_up_to_the_nearest_ancestor_that_stays():
    memory = line_of_options(5)
    chain = Forest(1, 2, np.ones(1))
    for n, value in enumerate(memory.forest.view().values):
        chain.add(value, n - 1, step=0)
    events = chain.remove_all(np.array([1, 2]), np.array([0, 3]), step=7)
    chain.check_invariants()
    assert chain.view().parents.tolist() == [-1, -1, -1, 0, 3]
    assert [(e.option, e.parent) for e in events if e.kind is GrowthKind.MOVED] == [(3, 0)]
    with pytest.raises(ValueError, match="no living option 3"):
        chain.remove_all(np.array([3, 3]), np.array([0, 0]), step=8)


def bundled() -> AO2:
    return AO2.load(saved_schemas() / "MountainCar-v0.ao2")


def check_forest(agent: AO2) -> None:
    view = agent.forest
    forest = Forest(view.values.shape[1], view.weights.shape[1], view.attention)
    forest.set_state(dict(agent.to_saved().state))
    forest.check_invariants()


def test_a_real_agent_gets_smaller_and_decides_the_same(tmp_path):
    agent = bundled()
    before = len(agent.forest)
    visits = agent.forest.visits[agent.forest.is_alive].sum()
    done = agent.cleanse()
    assert done.options_before == before
    assert done.options_after == len(agent.forest) < 0.8 * before
    assert done.values_changed == 0
    assert done.states == sum(map(len, agent.episodes)) > 0
    assert done.states_changed < 0.1 * done.states
    assert agent.forest.visits[agent.forest.is_alive].sum() == visits
    alive = set()
    for event in agent.growth:
        if event.kind is GrowthKind.CREATED:
            alive.add(event.option)
        elif event.kind is GrowthKind.REMOVED:
            alive.remove(event.option)
    assert alive == set(np.flatnonzero(agent.forest.is_alive).tolist())
    # What was imagined leads to options that are still there.
    ends = agent.to_saved().state["imagination_end_ids"][agent.forest.is_alive]
    assert agent.forest.is_alive[ends[ends >= 0]].all()
    agent.save(tmp_path / "small.ao2")
    again = AO2.load(tmp_path / "small.ao2")
    np.testing.assert_array_equal(again.learn(100).forest.weights, agent.learn(100).forest.weights)
    check_forest(again)


def test_as_a_setting_it_is_what_learning_ends_with():
    plain = AO2("MountainCar-v0", seed=2, warmup_steps=100).learn(1500)
    told = AO2("MountainCar-v0", seed=2, warmup_steps=100, cleansing=0.1).learn(1500)
    assert len(told.forest) < len(plain.forest)
    plain.cleanse(0.1)
    for name, array in told.to_saved().state.items():
        np.testing.assert_array_equal(array, plain.to_saved().state[name], err_msg=name)


def test_settling_in_the_middle_of_an_episode_leaves_nothing_dangling():
    agent = AO2("MountainCar-v0", seed=2, warmup_steps=100, cleansing=0.3, story_length=5)
    stepper = agent.stepper()
    gone = 0
    for _ in range(12):
        for _ in range(70):
            stepper.step()
        before = len(agent.forest)
        agent.settle()
        gone += before - len(agent.forest)
        check_forest(agent)
    assert gone > 20


def test_what_cannot_be_cleansed_says_so():
    with pytest.raises(ValueError, match="anticipating preset can be cleansed"):
        AO2("CartPole-v1", Preset.PAPER).cleanse()
    with pytest.raises(ValueError, match="cleansing between 0 and 1"):
        bundled().cleanse(1.5)
    assert AO2("CartPole-v1").cleanse().options_before == 0
