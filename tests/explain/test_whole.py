"""The whole agent: counted over states, checked by asking it, and honest about how often."""

import json
from collections.abc import Callable

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.core.config import PaperConfig
from ao2viz.explain.agreement import tell_faithfulness
from ao2viz.explain.faithful import Agreement
from ao2viz.explain.plain import to_plain
from ao2viz.explain.whole import (
    MOST_SEARCHED,
    compare_minds,
    find_highlights,
    find_roles,
    measure_attention,
    measure_coverage,
    measure_novelty,
    radius_of,
    sample_states,
)
from ao2viz.explain.whole_telling import tell_roles
from ao2viz.whole import WholeAgent
from tests.explain.agents import bundled, hand_made, some_states


def test_attention_is_the_share_of_each_feature_in_the_distance() -> None:
    mind = hand_made([[0.0, 0.0], [4.0, 4.0]], [[1, 0], [0, 1]], [1.0, 3.0])
    told = measure_attention(mind, np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 0.0]]))
    np.testing.assert_allclose(told.shares, [(1 + 0.25) / 2, (0 + 0.75) / 2])
    assert told.states == 2  # At the value itself there is no distance.


def test_roles_are_found_by_muting_and_asking_again() -> None:
    # 1 stands beside 0 and prefers the same; without 2 the second action is never taken.
    mind = hand_made([[0.0], [0.5], [3.0], [9.0]], [[1, 0], [1, 0], [0, 1], [1, 0]])
    states = np.array([[0.0], [0.5], [2.9], [0.1]])
    told = find_roles(mind, states)
    assert told.deciding.tolist() == [0, 1, 2]
    assert told.decided.tolist() == [2, 1, 1]
    assert told.redundant.tolist() == [0, 1]
    assert (told.supporting.tolist(), told.idle) == ([], 1)


def test_of_a_trained_agent_muting_what_is_redundant_changes_nothing() -> None:
    agent = bundled("MountainCar-v0")
    mind, states = agent.explain.mind, sample_states(some_states(agent, step=3), 60)
    told = find_roles(mind, states)
    actions = [mind.act(state) for state in states]
    assert 0 < len(told.redundant) < len(told.deciding)
    for option in told.deciding.tolist():
        with mind.muted(option):
            same = [mind.act(state) for state in states] == actions
        assert same == (option in told.redundant)
    assert len(told.supporting) > 0
    assert told.idle + len(told.supporting) + len(told.deciding) == len(mind.view)


def test_the_alarm_rings_where_learning_would_make_a_new_option() -> None:
    config = PaperConfig(threshold=0.75)
    mind = hand_made([[0.0], [1.0]], [[1, 0], [0, 1]], config=config)
    assert radius_of(mind) == 0.25
    states = np.array([[0.0], [0.1], [0.5]])
    told = measure_coverage(mind, states)
    assert told.share == pytest.approx(2 / 3)
    assert told.farthest == 2
    known, new = (measure_novelty(mind, np.array([x]), states) for x in (1.2, 2.0))
    assert not known.is_alarm
    assert known.rank == pytest.approx(1 / 3)
    assert new.is_alarm
    assert new.rank == 0.0


def test_it_does_not_ring_where_a_trained_agent_has_been() -> None:
    agent = bundled("CartPole-v1")
    explain = agent.explain
    assert explain.whole.coverage().share > 0.95
    assert not explain.novelty(agent.episodes[0].observations[100]).is_alarm
    told = explain.novelty([4.0, 5.0, -0.4, 5.0])
    assert told.is_alarm
    assert explain.tell(told).startswith("Never seen before: nothing known lies within 0.125.")


def test_highlights_are_the_most_important_moments_and_do_not_overlap() -> None:
    episodes = bundled("MountainCar-v0").episodes
    found = find_highlights(episodes, count=4, around=6)
    assert len(found) == 4
    values = [np.ptp(d.action_values) for episode in episodes for d in episode.decisions]
    assert found[0].importance == max(values)
    assert [h.importance for h in found] == sorted((h.importance for h in found), reverse=True)
    for one in found:
        assert one.first <= one.step <= one.last < len(episodes[one.episode])
        for other in found:
            if one is not other and one.episode == other.episode:
                assert one.last < other.first or other.last < one.first


def test_disagreements_are_found_and_those_that_matter_come_first() -> None:
    one, other = bundled("CartPole-v1"), AO2("CartPole-v1", "paper", seed=1).learn(300)
    told = one.explain.disagreements(other)
    assert len(told.states) == 1000 + len(other.forest)
    assert told.disagreements
    for moment in told.disagreements[::40]:
        state = told.states[moment.place]
        assert one.decide(state).action == moment.one != moment.other
        assert other.decide(state).action == moment.other
    cares = [min(m.one_cares, m.other_cares) for m in told.disagreements]
    assert cares == sorted(cares, reverse=True)
    assert one.explain.disagreements(one).share == 0
    with pytest.raises(ValueError, match="two agents of the same task"):
        compare_minds(one.explain.mind, bundled("Pendulum-v1").explain.mind, told.states)


def test_muting_an_option_costs_what_the_same_episodes_earn_less() -> None:
    agent = bundled("CartPole-v1")
    whole = agent.explain.whole
    options = whole.roles().deciding[:2].tolist()
    told = whole.carriers(options, episodes=2)
    assert told.mean_return == agent.evaluate(episodes=2).mean()
    assert {one.option for one in told.muted} == set(options)
    for one in told.muted:
        assert one.loss == pytest.approx(told.mean_return - one.mean_return)
    assert told.is_complete
    short = whole.carriers(options, episodes=1, on_progress=lambda state: False)
    assert (len(short.muted), short.is_complete) == (1, False)
    assert "Called off" in agent.explain.tell(short)


@pytest.mark.parametrize("env_id", ["CartPole-v1", "Pendulum-v1"])
def test_explanations_of_trained_agents_are_faithful_everywhere_and_it_is_counted(env_id) -> None:
    agent = bundled(env_id)
    told = agent.explain.whole.overview()
    assert told.faithfulness is not None
    for agreement in (told.faithfulness.parts, told.faithfulness.lines, told.faithfulness.flips):
        assert agreement.tried > 100
        assert agreement.share == 1.0
    assert told.faithfulness.repeated == Agreement(
        agreed=told.faithfulness.repeated.tried, tried=told.faithfulness.repeated.tried
    )
    text = agent.explain.tell(told)
    assert f"{told.faithfulness.parts.agreed:,} of {told.faithfulness.parts.tried:,} parts" in text
    json.dumps(to_plain(told), allow_nan=False)


def test_an_agent_that_has_changed_since_is_not_called_the_same() -> None:
    agent = AO2("CartPole-v1", "paper", seed=2).learn(300)
    agent.record_episode(7)
    agent.learn(600)
    told = agent.explain.whole.faithfulness()
    assert told.repeated.agreed < told.repeated.tried
    assert np.isnan(Agreement(0, 0).share)


def test_only_what_json_can_say_leaves() -> None:
    assert to_plain({"a": (1, np.float64(np.nan), np.array([True]))}) == {"a": [1, None, [True]]}
    with pytest.raises(TypeError, match="there is a object in it"):
        to_plain([object()])


def test_called_off_roles_tell_of_what_was_asked() -> None:
    agent = bundled("MountainCar-v0")
    mind, states = agent.explain.mind, sample_states(some_states(agent, step=3), 60)
    whole = find_roles(mind, states)
    asked: list[float] = []

    def end_after(share: float) -> Callable[[float], bool]:
        return lambda done: bool(asked.append(done)) or done < share

    early = find_roles(mind, states, end_after(0.25))
    assert early.states == 30
    assert early.deciding.tolist() == find_roles(mind, states[:30]).deciding.tolist()
    assert (early.tried, len(early.redundant)) == (0, 0)
    late = find_roles(mind, states, end_after(0.75))
    assert late.deciding.tolist() == whole.deciding.tolist()
    assert 0 < late.tried < whole.tried == len(whole.deciding)
    first = set(whole.deciding[: late.tried].tolist())
    assert set(late.redundant.tolist()) == set(whole.redundant.tolist()) & first
    assert f"of the {late.tried:,} that were tried before" in tell_roles(late)
    assert asked == sorted(asked[:31]) + sorted(asked[31:])


def test_called_off_in_the_midst_of_an_option_tells_of_the_options_before() -> None:
    agent = bundled("CartPole-v1")
    whole = agent.explain.whole
    options = whole.roles().deciding[:3].tolist()
    played: list[int] = []

    def play_on(episodes: int) -> bool:
        played.append(episodes)
        return episodes < 5

    told = whole.carriers(options, episodes=2, on_episode=play_on)
    assert played == [1, 2, 3, 4, 5]
    assert [one.option for one in told.muted] == [options[0]]
    assert (told.episodes, told.is_complete) == (2, False)
    expected = whole.carriers(options[:1], episodes=2)
    assert told.muted == expected.muted
    first = whole.carriers(options, episodes=2, on_episode=lambda _: False)
    assert (first.episodes, first.muted, first.is_complete) == (1, (), False)


def test_called_off_faithfulness_tells_of_what_was_tried() -> None:
    whole = bundled("CartPole-v1").explain.whole
    told = whole.faithfulness(lambda share: share < 0.21)  # In the midst of the second of five.
    assert told.parts.tried == 400
    assert 0 < told.lines.tried < 400
    assert told.lines.share == 1.0
    assert told.flips.tried == told.repeated.tried == 0
    assert "lines tell the action" in tell_faithfulness(told)


def test_of_very_many_states_some_are_searched_and_the_farthest_is_told_by_its_place() -> None:
    n = 3 * MOST_SEARCHED
    mind = hand_made([[0.0]], [[1, 0]])
    agent = bundled("CartPole-v1")
    values = np.zeros((n, 1))
    values[-1] = 5.0
    whole = WholeAgent(mind, agent.spec, (), lambda: agent.env, lambda: agent.explain.ranges)
    whole.states = lambda: values
    told = whole.coverage()
    assert len(told.distances) == MOST_SEARCHED
    assert told.farthest == n - 1
    assert whole.attention().states == 1
