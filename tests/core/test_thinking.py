"""Thinking ahead: the best imagined sequence, found the plain way as well, and told as it was."""

import heapq
from dataclasses import fields, replace

import numpy as np
import pytest

from ao2viz.core.config import Preset, make_config
from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.experience import allocate_experience, predict, record
from ao2viz.core.forest import Forest
from ao2viz.core.imagination import allocate_imagination, rules_of
from ao2viz.core.inference import Reading, choose_action, decide, find_shares
from ao2viz.core.local_linear import make_workspace
from ao2viz.core.thinking import (
    Horizon,
    begin,
    find_best_ends,
    imagine_ahead,
    standing_clock,
    think_over,
)
from tests.core.test_learners import Valley, assert_same_mind, grown, live, new_learner

LEFT, RIGHT = 0, 1


class Corridor:
    """Options at the whole numbers 0 … 9, an attention of 1; what is known there is told by hand.

    The weights are what a decision without thinking goes by, the values what a place is worth.
    """

    def __init__(self, gamma=0.5):
        config = make_config(
            Preset.ANTICIPATING, {"gamma": gamma, "levels": 3, "effect_ridge": 1e-9}
        )
        self.rules = rules_of(config)
        self.forest = Forest(1, 2, np.ones(1))
        self.forest.reserve(10)
        for n in range(10):
            self.forest.add(np.array([float(n)]), -1, n)
        self.experience = allocate_experience(self.forest.capacity, 2, 1)
        self.imagination = allocate_imagination(self.forest.capacity, 2, 5)
        # With room for two, only the nearest has a say: the other marks how far that reaches.
        self.work = make_workspace(2, 1, 2)

    def knows(self, place, action, leads_to, reward=0.0, terminated=False):
        before, after = np.array([float(place)]), np.array([float(leads_to)])
        visits = self.forest.columns.visits
        record(visits, self.experience, place, action, before, after, reward, terminated, 20)
        return self

    def is_walkable(self):
        """One place further for each action, for nothing."""
        for place in range(10):
            self.knows(place, LEFT, max(place - 1, 0)).knows(place, RIGHT, min(place + 1, 9))
        return self

    def without_thinking(self, place=5.0):
        reading = Reading(DecideBy.PATH, 0.02, has_outlook=False)
        return decide(self.forest, np.array([float(place)]), reading, self.work)

    def thinking(self, steps, place=5.0, limit=0.0, clock=standing_clock):
        mind = self.forest, self.experience, self.imagination
        horizon = Horizon(steps, limit, clock)
        before = self.without_thinking(place)
        return think_over(before, *mind, horizon, self.rules, self.work)


def test_what_is_wrong_at_one_step_is_right_at_two():
    corridor = Corridor().is_walkable()
    corridor.knows(4, LEFT, 3)  # Nothing there.
    corridor.imagination.value[4] = 1.0
    corridor.imagination.value[7] = 100.0
    corridor.forest.columns.weights[5] = 3.0, 2.0
    assert corridor.without_thinking().action == LEFT
    one = corridor.thinking(1)
    assert one.action == LEFT
    np.testing.assert_allclose(one.action_values, [0.5, 0.0], atol=1e-6)
    two = corridor.thinking(2)
    assert two.action == RIGHT
    np.testing.assert_allclose(two.action_values, [0.0, 25.0], atol=1e-5)
    plan = two.plan
    assert plan is not None
    assert plan.actions.tolist() == [RIGHT, RIGHT]
    assert plan.options.tolist() == [6, 7]
    np.testing.assert_allclose(plan.states, [[6.0], [7.0]], atol=1e-6)
    np.testing.assert_allclose(plan.worth, 100.0, rtol=1e-6)
    assert plan.outlook_values.tolist() == two.outlook_values.tolist() == [3.0, 2.0]


def test_equally_good_actions_are_a_tie_and_the_plan_is_the_first_one_imagined():
    decision = Corridor().is_walkable().thinking(2)
    assert decision.is_tie
    assert decision.action == choose_action(np.zeros(2), decision.observation)[0]
    assert decision.plan is not None
    assert decision.plan.actions.tolist() == [decision.action, LEFT]


def test_where_nothing_is_known_of_any_action_it_does_not_think():
    corridor = Corridor()
    corridor.forest.columns.weights[5] = 3.0, 2.0
    decision = corridor.thinking(3)
    assert decision.plan is None
    assert decision.action_values.tolist() == [3.0, 2.0]


def test_an_action_that_is_unknown_keeps_what_the_options_say_of_it():
    corridor = Corridor().knows(5, RIGHT, 6, reward=1.0)
    corridor.forest.columns.weights[5] = 3.0, 2.0
    decision = corridor.thinking(2)
    # From 6 on nothing is known, so the sequence ends there.
    np.testing.assert_allclose(decision.action_values, [3.0, 1.0])
    assert decision.action == LEFT
    plan = decision.plan
    assert plan is not None
    assert len(plan.actions) == 0
    assert plan.states.shape == (0, 1)
    assert plan.worth == 3.0
    corridor.forest.columns.weights[5, LEFT] = 0.5
    short = corridor.thinking(3).plan
    assert short is not None
    assert short.actions.tolist() == [RIGHT]


def test_a_sequence_may_end_where_one_of_the_actions_is_unknown():
    corridor = Corridor().knows(5, RIGHT, 6).knows(6, RIGHT, 7)
    corridor.imagination.value[6] = 10.0
    corridor.imagination.value[7] = 1.0
    plan = corridor.thinking(2).plan
    assert plan is not None
    # Going on is worth less than being at 6, from where the left is unknown.
    assert plan.actions.tolist() == [RIGHT]
    corridor.knows(6, LEFT, 5)
    again = corridor.thinking(2)
    assert again.plan is not None
    assert again.plan.actions.tolist() == [RIGHT, RIGHT]
    np.testing.assert_allclose(again.action_values[RIGHT], 0.25, rtol=1e-6)


def test_nothing_comes_after_the_end():
    corridor = Corridor().knows(5, RIGHT, 6, reward=2.0, terminated=True).knows(6, RIGHT, 7, 50.0)
    corridor.imagination.value[:] = 100.0
    decision = corridor.thinking(3)
    plan = decision.plan
    assert plan is not None
    assert (plan.actions.tolist(), plan.continues.tolist(), plan.worth) == ([RIGHT], [0.0], 0.0)
    assert decision.action_values[RIGHT] == 2.0


def test_a_chance_of_ending_counts_what_comes_after_for_less():
    corridor = Corridor(gamma=1.0)
    corridor.knows(5, RIGHT, 6, reward=1.0).knows(5, RIGHT, 6, reward=1.0, terminated=True)
    corridor.knows(6, RIGHT, 7, reward=4.0)
    corridor.imagination.value[7] = 10.0
    corridor.forest.columns.weights[5] = -1.0, 0.0
    decision = corridor.thinking(2)
    assert decision.plan is not None
    np.testing.assert_allclose(decision.plan.continues, [0.5, 0.5])
    np.testing.assert_allclose(decision.plan.rewards, [1.0, 4.0])
    np.testing.assert_allclose(decision.action_values[RIGHT], 1.0 + 0.5 * (4.0 + 10.0))


def test_without_options_there_is_nothing_to_think_with():
    learner = new_learner(Preset.ANTICIPATING, think_ahead=3)
    learner.start(np.zeros(2))
    assert learner.decide_at(np.zeros(2)).plan is None
    assert learner.act_at(np.zeros(2)) in (LEFT, RIGHT)


def plain_search(learner, observation, depth, budget=None):
    """What `think_over` expects of every action: best-first search, written plainly."""
    forest, rules, work = learner._forest, learner._rules, learner._work
    columns, value = forest.columns, learner._imagination.value
    nodes = [{"at": forest.attention * observation, "sequence": (), "earned": 0.0, "on": 1.0}]
    nodes[0]["end"] = False
    queue = [(0.0, 0)]
    while queue and (budget is None or len(nodes) < 1 + budget):
        here = nodes[heapq.heappop(queue)[1]]
        here["end"] = False
        for action in range(forest.n_actions):
            state = here["at"]
            ridge = rules.effect_ridge
            if not predict(columns, learner._experience, state, action, rules.radius, ridge, work):
                here["end"] = True
                continue
            effect = work.effect.copy()
            steps = len(here["sequence"]) + 1
            node = {"at": state + effect[:-2], "sequence": (*here["sequence"], action), "end": True}
            node["earned"] = here["earned"] + rules.gamma ** (steps - 1) * here["on"] * effect[-2]
            node["on"] = here["on"] * (1 - effect[-1])
            n = find_shares(columns, node["at"], rules.share_ridge, False, work)
            worth = work.shares[:n] @ value[work.ids[:n]] if node["on"] > 0 else 0.0
            node["total"] = node["earned"] + rules.gamma**steps * node["on"] * worth
            nodes.append(node)
            if steps < depth and node["on"] > 0:
                heapq.heappush(queue, (-node["total"], len(nodes) - 1))
    best = {}
    for node in nodes[1:]:
        if node["end"] and node["total"] > best.get(node["sequence"][0], (-np.inf,))[0]:
            best[node["sequence"][0]] = node["total"], node["sequence"]
    return best


def places(n, seed=4):
    return np.random.default_rng(seed).normal(0.0, [0.5, 0.3], (n, 2))


@pytest.mark.parametrize("depth", [1, 2, 3])
@pytest.mark.parametrize("seed", [0, 1])
def test_it_finds_the_best_of_all_sequences(seed, depth):
    learner = grown(Preset.ANTICIPATING, 800, seed)
    for observation in places(40):
        before = learner.decide_at(observation)
        learner.change({"think_ahead": depth, "think_limit": 0})
        decision = learner.decide_at(observation)
        learner.change({"think_ahead": 0, "think_limit": 0})
        best = plain_search(learner, observation, depth)
        if not best:
            assert decision.plan is None
            continue
        expected = [best[a][0] if a in best else before.action_values[a] for a in range(2)]
        np.testing.assert_allclose(decision.action_values, expected, rtol=1e-9)
        np.testing.assert_array_equal(decision.outlook_values, before.action_values)
        plan = decision.plan
        assert plan is not None
        assert decision.action_values[decision.action] == decision.action_values.max()
        if decision.action in best:
            assert tuple(plan.actions.tolist()) == best[decision.action][1]
            assert plan.actions[0] == decision.action


@pytest.mark.parametrize("budget", [2, 6, 14, 30])
def test_cut_short_it_has_looked_at_what_promises_most(budget):
    learner = grown(Preset.ANTICIPATING, 800)
    for observation in places(40):
        thoughts = begin(learner._forest.attention * observation, 2, 6, learner._rules.gamma)
        mind = learner._forest.columns, learner._experience, learner._imagination, thoughts
        imagine_ahead(*mind, budget, learner._rules, learner._work)
        best = np.empty(2, np.int64)
        find_best_ends(thoughts, best)
        expected = plain_search(learner, observation, 6, budget)
        assert {a for a in range(2) if best[a] >= 0} == expected.keys()
        for action, (total, _) in expected.items():
            np.testing.assert_allclose(thoughts.totals[best[action]], total, rtol=1e-9)


def test_bit_by_bit_it_imagines_what_it_would_at_once():
    learner = grown(Preset.ANTICIPATING, 800)
    for observation in places(10):
        at_once, bit_by_bit = (
            begin(learner._forest.attention * observation, 2, 4, learner._rules.gamma)
            for _ in range(2)
        )
        world = learner._forest.columns, learner._experience, learner._imagination
        assert not imagine_ahead(*world, at_once, 10**6, learner._rules, learner._work)
        while imagine_ahead(*world, bit_by_bit, 3, learner._rules, learner._work):
            pass
        n = at_once.used[0]
        for name in at_once._fields:
            one, other = getattr(at_once, name), getattr(bit_by_bit, name)
            np.testing.assert_array_equal(one[:n], other[:n], err_msg=name)


def test_there_is_only_so_much_room(monkeypatch):
    monkeypatch.setattr("ao2viz.core.thinking.MOST_IMAGINED", 9)
    decision = Corridor().is_walkable().thinking(8)
    assert decision.plan is not None
    thoughts = begin(np.zeros(1), 2, 8, 0.9)
    assert len(thoughts.parents) == 10


def assert_same_plan(one, other):
    assert one.action_values.tobytes() == other.action_values.tobytes()
    assert (one.plan is None) == (other.plan is None)
    if one.plan is not None:
        for field in fields(one.plan):
            ours, theirs = getattr(one.plan, field.name), getattr(other.plan, field.name)
            np.testing.assert_array_equal(ours, theirs, err_msg=field.name)


class Ticking:
    """A clock that is a millisecond later whenever it is read."""

    def __init__(self):
        self.read = 0

    def __call__(self):
        self.read += 1
        return self.read / 1000


def test_thinking_ends_when_its_time_is_up():
    corridor = Corridor().is_walkable()
    corridor.imagination.value[:10] = np.arange(10)
    hurried, patient = Ticking(), Ticking()
    hasty = corridor.thinking(8, limit=0.0015, clock=hurried)
    assert hasty.plan is not None
    assert hurried.read == 3
    unhurried = corridor.thinking(8, limit=60.0, clock=patient)
    assert patient.read > 10
    assert_same_plan(unhurried, corridor.thinking(8))


def test_what_an_action_is_expected_to_earn_is_the_sum_over_its_plan():
    learner = grown(Preset.ANTICIPATING, 1000, gamma=0.9)
    lengths = set()
    for depth in (1, 2, 4):
        learner.change({"think_ahead": depth, "think_limit": 0})
        for observation in places(100):
            decision = learner.decide_at(observation)
            if decision.plan is None:
                continue
            lengths.add(len(decision.plan.actions))
            assert summed(decision, 0.9) == decision.action_values[decision.action]
            if len(decision.plan.actions):
                assert decision.plan.actions[0] == decision.action
    assert lengths >= {1, 2, 4}


def summed(decision: Decision, gamma: float) -> float:
    plan = decision.plan
    assert plan is not None
    total, power, goes_on = 0.0, 1.0, 1.0
    for reward, after in zip(plan.rewards, plan.continues, strict=True):
        total += power * goes_on * reward
        power *= gamma
        goes_on = after
    return total + power * goes_on * plan.worth


@pytest.mark.parametrize("decide_by", list(DecideBy))
def test_asking_and_acting_agree_and_repeat_to_the_bit(decide_by):
    learner = grown(Preset.ANTICIPATING, think_ahead=2, decide_by=decide_by)
    again = new_learner(Preset.ANTICIPATING, think_ahead=2, decide_by=decide_by)
    again.set_state(learner.get_state())
    for observation in places(100):
        decision, other = learner.decide_at(observation), again.decide_at(observation)
        assert learner.act_at(observation) == decision.action == other.action
        assert_same_plan(decision, other)


def test_it_can_think_while_it_learns_and_not_about_what_it_draws():
    settings = {"think_ahead": 2, "epsilon_end": 0.3}
    learner, planned = new_learner(Preset.ANTICIPATING, **settings), 0
    for decision, _, _ in live(learner, Valley(0), 400):
        assert not (decision.explored and decision.plan is not None)
        planned += decision.plan is not None
    assert planned > 50
    assert_same_mind(learner, grown(Preset.ANTICIPATING, 400, **settings))


def test_switching_it_on_and_off_again_leaves_nothing_behind():
    learner = grown(Preset.ANTICIPATING)
    state = learner.get_state()
    observation = np.array([0.3, 0.1])
    before = learner.decide_at(observation)
    learner.change({"think_ahead": 3, "think_limit": 0})
    learner.decide_at(observation)
    learner.change({"think_ahead": 0, "think_limit": 0})
    after = learner.decide_at(observation)
    assert after.plan is None
    assert after.action_values.tobytes() == before.action_values.tobytes()
    for name, array in learner.get_state().items():
        np.testing.assert_array_equal(array, state[name], err_msg=name)


def test_a_feature_without_attention_stays_as_it_is_seen():
    corridor = Corridor().is_walkable()
    corridor.forest.attention[:] = 0.0
    decision = replace(corridor.without_thinking(), observation=np.array([0.25]))
    mind = corridor.forest, corridor.experience, corridor.imagination
    thought = think_over(
        decision, *mind, Horizon(1, 0.0, standing_clock), corridor.rules, corridor.work
    )
    assert thought.plan is not None
    assert thought.plan.states.tolist() == [[0.25]]


@pytest.mark.parametrize(
    ("name", "value"), [("think_ahead", 9), ("think_ahead", -1), ("think_ahead", 1.5),
                        ("think_limit", -1), ("think_limit", 60_001)]
)  # fmt: skip
def test_bad_settings_are_refused(name, value):
    with pytest.raises(ValueError, match=f"Expected {name}"):
        make_config(Preset.ANTICIPATING, {name: value})
