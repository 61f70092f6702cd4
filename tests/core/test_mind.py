"""A mind decides as the agent did, and tells the planes that the agent decides by."""

from dataclasses import replace

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.core.config import AnticipatingConfig, PaperConfig
from ao2viz.core.decision import DecideBy
from ao2viz.core.mind import Mind
from ao2viz.resources import saved_schemas
from tests.forests import random_view

BUNDLED = ["CartPole-v1", "Pendulum-v1", "MountainCar-v0", "Acrobot-v1"]


@pytest.fixture(scope="module", params=BUNDLED)
def agent(request: pytest.FixtureRequest) -> AO2:
    return AO2.load(saved_schemas() / f"{request.param}.ao2")


def mind_of(agent: AO2, config: object = None) -> Mind:
    return Mind(agent.config if config is None else config, agent.to_saved().state)


def recorded(agent: AO2) -> np.ndarray:
    return np.concatenate([episode.observations[:-1] for episode in agent.episodes])


def test_it_decides_as_the_agent_to_the_bit(agent: AO2) -> None:
    mind = mind_of(agent)
    alone = Mind.from_view(agent.forest, agent.config)
    for seen in recorded(agent)[::7]:
        expected = agent.decide(seen)
        for decided in (mind.decide(seen), alone.decide(seen)):
            assert decided.action == expected.action
            np.testing.assert_array_equal(decided.action_values, expected.action_values)
            np.testing.assert_array_equal(decided.path_distances, expected.path_distances)
        assert mind.act(seen) == expected.action


def test_it_votes_and_thinks_ahead_as_the_agent_does(agent: AO2) -> None:
    for change in ({"decide_by": DecideBy.VOTE}, {"think_ahead": 2}):
        config = replace(agent.config, **change)
        mind = mind_of(agent, config)
        asked = AO2.load(saved_schemas() / f"{agent.spec.env_id}.ao2")
        asked.set_decide_by(config.decide_by)
        asked.set_think_ahead(config.think_ahead)
        for seen in recorded(agent)[::50]:
            np.testing.assert_array_equal(
                mind.decide(seen).action_values, asked.decide(seen).action_values
            )


def test_a_plane_says_what_the_option_decides_by(agent: AO2) -> None:
    mind = mind_of(agent)
    for seen in recorded(agent)[::7]:
        decision = agent.decide(seen)
        levels, slopes = mind.planes(decision.voters)
        np.testing.assert_array_equal(slopes[0] * agent.forest.attention, decision.slopes)
        gap = agent.forest.attention * (seen - agent.forest.values[decision.voters[0]])
        np.testing.assert_allclose(levels[0] + slopes[0] @ gap, decision.action_values, rtol=1e-12)


def test_planes_rest_on_the_neighbours_and_on_nobody_else() -> None:
    view = random_view(60, seed=3)
    config = AnticipatingConfig()
    mind = Mind.from_view(view, config)
    near = mind.neighbours(7)
    assert 7 in near
    for other in range(60):
        weights = view.weights.copy()
        weights[other] += 1.0
        changed = Mind.from_view(replace(view, weights=weights), config).planes([7])
        if other not in near:
            np.testing.assert_array_equal(changed.levels, mind.planes([7]).levels)
    assert len(near) == 16


def test_without_outlooks_a_plane_is_the_options_own_weights() -> None:
    view = random_view(20)
    mind = Mind.from_view(view, PaperConfig())
    levels, slopes = mind.planes([3, 5])
    np.testing.assert_array_equal(levels, view.weights[[3, 5]])
    assert not slopes.any()
    assert mind.neighbours(3).tolist() == [3]


def test_a_muted_option_is_as_good_as_gone_and_then_back() -> None:
    view = random_view(80, seed=1)
    config = AnticipatingConfig()
    mind = Mind.from_view(view, config)
    places = np.random.default_rng(2).normal(size=(40, 4))
    before = [mind.decide(place).action_values for place in places]
    for option in (0, 17, 79):
        gone = Mind.from_view(view, config)
        gone.forest.remove(option, step=0)
        with mind.muted(option):
            for place in places:
                np.testing.assert_array_equal(
                    mind.decide(place).action_values, gone.decide(place).action_values
                )
    for place, expected in zip(places, before, strict=True):
        np.testing.assert_array_equal(mind.decide(place).action_values, expected)
    mind.forest.check_invariants()


def test_a_copy_decides_alike_and_shares_nothing() -> None:
    mind = Mind.from_view(random_view(30), AnticipatingConfig())
    other = mind.copy()
    with other.muted(3):
        assert mind.forest.nearest(mind.view.values[3])[0][0] == 3
