"""What both learners promise: the same seed, the same mind; the path shown, the path taken."""

import copy
import dataclasses

import numpy as np
import pytest

from ao2viz import AO2
from ao2viz.core.agent import make_learner
from ao2viz.core.attention import attention_from
from ao2viz.core.config import Preset, make_config
from ao2viz.core.decision import NO_OPTION, DecideBy
from ao2viz.core.growth import GrowthKind
from ao2viz.core.imagination import worth_of

RANGES = np.array([2.0, 2.0])
# Small enough to be quick, and the forest is regrown at least once.
SETTINGS = {
    Preset.ANTICIPATING: {"warmup_steps": 60, "levels": 3, "epsilon_steps": 400, "story_length": 8},
    Preset.PAPER: {"threshold": 0.95, "trace_length": 6, "credit": "return"},
}
PRESETS = list(Preset)


class Valley:
    """A ball in a valley, pushed left or right; away from the middle costs, too far ends it dearly.

    The random start grows wider with every episode, so that attention must widen too.
    """

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.episode = 0

    def reset(self):
        self.episode += 1
        width = min(0.1 * self.episode, 0.8)
        self.state = np.array([self.rng.uniform(-width, width), 0.0])
        self.time = 0
        return self.state.copy()

    def step(self, action):
        position, velocity = self.state
        velocity += 0.05 * (2 * action - 1) - 0.02 * position
        self.state = np.array([position + 0.2 * velocity, velocity])
        self.time += 1
        terminated = bool(abs(self.state[0]) > 1)
        reward = -abs(self.state[0]) - (20.0 if terminated else 0.0)
        return self.state.copy(), reward, terminated, self.time >= 50


def new_learner(preset, seed=0, **settings):
    config = make_config(preset, {**SETTINGS[preset], **settings})
    return make_learner(config, RANGES, 2, np.random.default_rng(seed))


def live(learner, world, steps):
    """Learns for some steps from a fresh episode; yields what happened at each."""
    ended = True
    for _ in range(steps):
        started = learner.start(world.reset()) if ended else ()
        decision = learner.decide()
        view = learner.view()
        observation, reward, terminated, truncated = world.step(decision.action)
        events = learner.observe(decision, reward, observation, terminated, truncated)
        ended = terminated or truncated
        yield decision, view, (*started, *events)


def grown(preset, steps=500, seed=0, **settings):
    learner = new_learner(preset, seed, **settings)
    for _ in live(learner, Valley(seed), steps):
        pass
    return learner


def assert_same_mind(one, other):
    ours, theirs = one.get_state(), other.get_state()
    assert ours.keys() == theirs.keys()
    for name in ours:
        np.testing.assert_array_equal(ours[name], theirs[name], err_msg=name)


@pytest.mark.parametrize("preset", PRESETS)
def test_the_same_seed_grows_the_same_forest_to_the_bit(preset):
    assert_same_mind(grown(preset), grown(preset))
    different = grown(preset, seed=1).view()
    assert not np.array_equal(different.values, grown(preset).view().values)


@pytest.mark.parametrize("preset", PRESETS)
def test_watching_changes_nothing(preset):
    watched = new_learner(preset)
    for decision, _, _ in live(watched, Valley(0), 500):
        watched.view()
        watched.decide_at(decision.observation * 0.9)
        watched.get_state()
    assert_same_mind(watched, grown(preset))


@pytest.mark.parametrize("steps", [30, 60, 61, 333])
@pytest.mark.parametrize("preset", PRESETS)
def test_load_and_continue_equals_never_stopped(preset, steps):
    stayed = new_learner(preset)
    world = Valley(7)
    for _ in live(stayed, world, steps):
        pass
    loaded = new_learner(preset, seed=99)
    loaded.set_state(stayed.get_state())
    loaded._rng.bit_generator.state = stayed._rng.bit_generator.state
    assert_same_mind(loaded, stayed)
    same_world = Valley(7)
    same_world.rng.bit_generator.state = world.rng.bit_generator.state
    same_world.episode = world.episode
    for _ in live(stayed, world, 300):
        pass
    for _ in live(loaded, same_world, 300):
        pass
    assert_same_mind(loaded, stayed)


def plane_around(view, option, ridge=0.02):
    """What `look_around` says, the plain way: a weighted ridge regression by least squares."""
    distances = np.where(view.is_alive, view.distances_to(view.values[option]), np.inf)
    order = np.lexsort((np.arange(len(distances)), distances))
    around = order[: 3 * (view.values.shape[1] + 1) + 1]
    around = around[view.is_alive[around]]
    width = max(distances[around[-1]], 1e-9)
    kernel = np.clip(1 - (distances[around] / width) ** 3, 0, None) ** 3
    design = np.ones((len(around), view.values.shape[1] + 1))
    design[:, 1:] = view.attention * (view.values[around] - view.values[option]) / width
    penalty = ridge * kernel.sum() * np.diag([0.0, *np.ones(view.values.shape[1])])
    normal = design.T @ (kernel[:, None] * design) + penalty
    planes = np.linalg.solve(normal, design.T @ (kernel[:, None] * view.weights[around]))
    return planes[0], planes[1:].T * view.attention / width


@pytest.mark.parametrize("decide_by", list(DecideBy))
@pytest.mark.parametrize("preset", PRESETS)
def test_every_decision_tells_exactly_what_led_to_it(preset, decide_by):
    spoke = 0
    for decision, view, _ in live(new_learner(preset, decide_by=decide_by), Valley(3), 400):
        k = len(decision.voters)
        assert decision.paths.shape == decision.path_distances.shape
        assert decision.voter_weights.shape == (k, 2)
        assert decision.decide_by is decide_by
        if k == 0:
            assert decision.is_tie
            continue
        spoke += 1
        distances = view.distances_to(decision.observation)
        # Paper, equation 4: no living option is more similar than the first voter.
        np.testing.assert_allclose(decision.distance, distances.min(), rtol=1e-12)
        np.testing.assert_allclose(distances[decision.voters[0]], distances.min(), rtol=1e-12)
        assert k == 1 or decide_by is DecideBy.VOTE
        for voter in range(k):
            path = decision.path_of(voter)
            np.testing.assert_array_equal(path, view.path_to(decision.voters[voter]))
            along = decision.path_distances[voter, : len(path)]
            np.testing.assert_allclose(along, distances[path], rtol=1e-12)
        np.testing.assert_array_equal(decision.voter_weights, view.weights[decision.voters])
        np.testing.assert_allclose(decision.shares.sum(), 1.0)
        assert (decision.shares >= 0).all()
        if preset is Preset.ANTICIPATING and decide_by is DecideBy.PATH:
            levels, slopes = plane_around(view, int(decision.voters[0]))
            gap = decision.observation - view.values[decision.voters[0]]
            np.testing.assert_allclose(decision.slopes, slopes, rtol=1e-6, atol=1e-9)
            np.testing.assert_allclose(decision.action_values, levels + slopes @ gap, rtol=1e-7)
        else:
            assert not decision.slopes.any()
            spoken = decision.shares @ decision.voter_weights
            np.testing.assert_allclose(decision.action_values, spoken)
        if not decision.explored:
            assert decision.action_values[decision.action] == decision.action_values.max()
            assert decision.margin >= 0
        others = np.delete(distances, decision.voters[0])
        if len(others) and np.isfinite(others.min()):
            np.testing.assert_allclose(decision.runner_up_distance, others.min(), rtol=1e-12)
    assert spoke > 300


@pytest.mark.parametrize("decide_by", list(DecideBy))
@pytest.mark.parametrize("preset", PRESETS)
def test_a_decision_stays_as_it_was_made_whatever_is_decided_and_learned_later(preset, decide_by):
    decisions, then = [], []
    for decision, _, _ in live(new_learner(preset, decide_by=decide_by), Valley(3), 300):
        decisions.append(decision)
        then.append(copy.deepcopy(decision))
    assert any(len(decision.voters) for decision in decisions)
    for decision, before in zip(decisions, then, strict=True):
        for field in dataclasses.fields(decision):
            now, once = getattr(decision, field.name), getattr(before, field.name)
            np.testing.assert_array_equal(now, once, err_msg=field.name)
        with pytest.raises(dataclasses.FrozenInstanceError, match="action"):
            decision.action = 0


@pytest.mark.parametrize("preset", PRESETS)
def test_asking_and_acting_agree(preset):
    learner = grown(preset)
    for observation in np.random.default_rng(5).normal(0, 0.5, (200, 2)):
        for decide_by in DecideBy:
            learner.change({"decide_by": decide_by})
            assert learner.act_at(observation) == learner.decide_at(observation).action


@pytest.mark.parametrize("preset", PRESETS)
def test_growth_events_tell_the_whole_structure(preset):
    learner = new_learner(preset)
    parents, links, alive = {}, set(), set()
    for _, _, events in live(learner, Valley(2), 600):
        for event in events:
            match event.kind:
                case GrowthKind.CREATED:
                    parents[event.option] = event.parent
                    alive.add(event.option)
                case GrowthKind.MOVED:
                    parents[event.option] = event.parent
                case GrowthKind.LINKED:
                    links.add((event.parent, event.option))
                case GrowthKind.REMOVED:
                    alive.remove(event.option)
                case GrowthKind.ATTENTION:
                    links.clear()
    view = learner.view()
    assert alive == set(np.flatnonzero(view.is_alive).tolist())
    assert {o: parents[o] for o in alive} == {o: int(view.parents[o]) for o in alive}
    assert links == {tuple(pair) for pair in view.links.tolist()}
    assert len(alive) > 20


def test_widened_attention_regrows_a_sound_forest():
    learner = new_learner(Preset.ANTICIPATING)
    regrown = []
    for _, _, events in live(learner, Valley(0), 1500):
        kinds = [event.kind for event in events]
        if GrowthKind.ATTENTION in kinds:
            regrown.append(kinds)
            learner._forest.check_invariants()
    assert len(regrown) > 1, "The world widens, so attention must have widened after the warm-up."
    assert any(GrowthKind.REMOVED in kinds for kinds in regrown)
    learner._forest.check_invariants()
    # Merging loses no experience: every step after its option was found is still counted.
    assert learner.view().visits[learner.view().is_alive].sum() == 1500


def test_nothing_grows_before_attention_is_set():
    learner = new_learner(Preset.ANTICIPATING)
    for n, (decision, view, _) in enumerate(live(learner, Valley(0), 60)):
        assert len(view) == 0, n
        assert decision.explored
    assert len(learner.view()) > 5


def test_the_anticipating_learner_learns_and_sleep_settles_its_values():
    learner = new_learner(Preset.ANTICIPATING)
    for _ in live(learner, Valley(0), 3000):
        pass
    learner.sleep()
    before = learner.view().weights
    learner.sleep()
    np.testing.assert_allclose(learner.view().weights, before, atol=2e-3 * np.abs(before).max())
    # Far to the right and moving right: pushing left must be worth more, and the reverse.
    for side in (-1, 1):
        decision = learner.decide_at(np.array([0.5 * side, 0.1 * side]))
        assert decision.action == (0 if side > 0 else 1)


def test_a_time_limit_is_no_failure_in_the_paper_preset():
    learner = new_learner(Preset.PAPER, credit="accumulate", failure_only=True)
    learner.start(np.zeros(2))
    learner.observe(learner.decide(), 1.0, np.ones(2) * 0.1, False, True)
    assert (learner.view().weights == 0).all()
    learner.start(np.zeros(2))
    decision = learner.decide()
    learner.observe(decision, 1.0, np.ones(2) * 0.1, True, False)
    assert learner.view().weights[0, decision.action] == -1.0


def test_credit_of_a_trace_fades_by_gamma_per_step():
    learner = new_learner(Preset.PAPER, credit="accumulate", gamma=0.5, trace_length=2)
    learner.start(np.zeros(2))
    first = learner.decide()
    learner.observe(first, 0.0, np.array([0.9, 0.9]), False, False)
    # The second state is far away: it is accommodated below the root, which still decides.
    second = learner.decide()
    assert second.created == 1
    learner.observe(second, 8.0, np.array([0.9, 0.9]), False, False)
    expected = np.zeros(2)
    expected[first.action] += 4.0
    expected[second.action] += 8.0
    np.testing.assert_array_equal(learner.view().weights[0], expected)


@pytest.mark.parametrize("credit", ["return", "bootstrap"])
@pytest.mark.parametrize("steps", [1, 2, 3, 7])
def test_every_action_is_moved_once_by_the_return_of_its_trace(credit, steps):
    learner = new_learner(
        Preset.PAPER, credit=credit, gamma=0.5, trace_length=3, step_size=0.1, threshold=0.0
    )
    learner.start(np.zeros(2))
    taken = []
    for step in range(steps):
        taken.append(learner.decide().action)
        learner.observe(learner.decide(), 8.0, np.zeros(2), step + 1 == steps, False)
    assert learner.view().visits[0].tolist() == [taken.count(0), taken.count(1)]
    if credit == "return":
        for action in set(taken):
            earned = [
                sum(8.0 * 0.5**k for k in range(min(3, steps - step)))
                for step in range(steps)
                if taken[step] == action
            ]
            weight = 0.0
            for n, one in enumerate(earned, 1):
                weight += max(0.1, 1 / n) * (one - weight)
            assert learner.view().weights[0, action] == pytest.approx(weight)


@pytest.mark.parametrize("preset", PRESETS)
def test_a_state_of_another_shape_is_refused_and_nothing_is_lost(preset):
    learner, other = grown(preset), grown(preset, steps=100)
    state = other.get_state()
    state["counters"] = np.zeros(9, np.int64)
    before = learner.view()
    with pytest.raises(ValueError, match="Expected array 'counters'"):
        learner.set_state(state)
    np.testing.assert_array_equal(learner.view().values, before.values)


def test_imagined_ends_outside_the_forest_are_refused():
    learner = grown(Preset.ANTICIPATING)
    state = learner.get_state()
    state["imagination_end_ids"][0, 0, 0] = 10**6
    with pytest.raises(ValueError, match="Expected option ids below"):
        learner.set_state(state)


def test_runner_up_option_is_none_when_there_is_only_one():
    learner = new_learner(Preset.PAPER)
    learner.start(np.zeros(2))
    decision = learner.decide()
    assert decision.runner_up_option == NO_OPTION
    assert np.isnan(decision.runner_up_distance)


def test_a_slip_makes_a_place_worth_less_the_more_it_could_cost():
    assert worth_of(np.array([10.0, 10.0]), 0.1) == pytest.approx(10.0)
    assert worth_of(np.array([0.0, 10.0]), 0.1) == pytest.approx(9.5)
    assert worth_of(np.array([0.0, 10.0]), 0.0) == 10.0
    assert worth_of(np.array([3.0, 6.0, 0.0]), 1.0) == pytest.approx(3.0)


def test_attention_follows_what_the_choice_depends_on_and_not_only_the_spread():
    spread, chosen = (
        AO2("CartPole-v1", seed=0, attention_relevance=share).learn(3000)._learner
        for share in (0.0, 1.0)
    )
    chosen._forest.check_invariants()
    by_spread = attention_from(spread._grown_at, spread.config.attention_width)
    by_choice = attention_from(chosen._grown_at, chosen.config.attention_width)
    np.testing.assert_allclose(spread.view().attention, by_spread)
    relevance = chosen.view().attention / by_choice
    assert relevance[2] > 1.5  # The pole's angle.
    assert relevance[0] < 0.9  # Where the cart is.
    np.testing.assert_allclose(np.log(relevance).mean(), 0.0, atol=1e-9)
