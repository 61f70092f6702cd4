"""Two agents from the same seeds: as they would play alone, and what their returns tell."""

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.experiments.duel import fight, put_beside, sum_up
from ao2viz.resources import saved_schemas


@pytest.fixture(scope="module")
def pair() -> tuple[AO2, AO2]:
    young = AO2("CartPole-v1", seed=3, warmup_steps=100, levels=2).learn(400)
    young.record_episode(1)
    return AO2.load(saved_schemas() / "CartPole-v1.ao2"), young


def test_both_play_as_they_would_alone(pair):
    one, other = pair
    found = fight(one.explain.mind, other.explain.mind, one.spec, seed=7, episodes=3)
    for agent, episode, returns in zip(pair, (found.one, found.other), found.returns, strict=True):
        alone = agent.record_episode(7)
        assert episode.actions.tolist() == alone.actions.tolist()
        assert episode.observations.tolist() == alone.observations.tolist()
        assert episode.total_reward == alone.total_reward
        assert returns.scores.tolist() == agent.evaluate(3, seed=7).tolist()
    assert (
        found.difference.scores.tolist()
        == (found.returns[0].scores - found.returns[1].scores).tolist()
    )
    parting = found.parting
    assert parting is not None
    assert found.one.actions[:parting].tolist() == found.other.actions[:parting].tolist()
    assert found.one.actions[parting] != found.other.actions[parting]


def test_an_agent_never_parts_from_itself(pair):
    mind = pair[0].explain.mind
    found = fight(mind, mind.copy(), pair[0].spec, seed=1, episodes=2)
    assert found.parting is None
    assert found.difference.interval == (0, 0)


def test_playing_ends_when_it_is_called_off(pair):
    one, other = (agent.explain.mind for agent in pair)
    seen = []

    def stop(duel) -> bool:
        seen.append(duel.played)
        return duel.played < 2

    found = fight(one, other, pair[0].spec, 1, 50, stop)
    assert (found.played, found.planned) == (2, 50)
    assert seen == [0, 1, 2]


def test_asked_at_the_same_states_they_answer_as_they_are(pair):
    one, other = pair
    episode = one.episodes[0]
    found = put_beside(
        one.explain.mind, other.explain.mind, episode, (one.episodes, other.episodes)
    )
    parted = {moment.place for moment in found.episode.disagreements}
    for step in range(0, len(episode), 25):
        seen = episode.observations[step]
        assert (one.decide(seen).action != other.decide(seen).action) == (step in parted)
    assert {s.name for s in found.settings} >= {"warmup_steps", "levels"}
    assert found.returns[0].scores.tolist() == [e.total_reward for e in one.episodes]


def test_returns_have_an_interval_as_soon_as_there_are_two():
    assert np.isnan(sum_up([]).iqm)
    assert sum_up([3.0]).interval is None
    found = sum_up([1.0, 2.0, 3.0, 4.0, 5.0, 90.0])
    low, high = found.interval
    assert low <= found.iqm <= high
    assert found.iqm == pytest.approx(np.mean([2, 3, 4, 5]))
