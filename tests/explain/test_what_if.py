"""What if: certain distances told in units are kept, and what cannot be asked is told."""

from dataclasses import replace

import numpy as np
import pytest

from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import DecideBy
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import ranges_by_id
from ao2viz.explain.what_if import find_flips_at, tell_certainty
from ao2viz.explain.words import amount
from tests.explain.agents import bundled, some_states


@pytest.mark.parametrize("env_id", ["CartPole-v1", "Pendulum-v1"])
def test_the_amounts_that_are_called_certain_change_nothing(env_id):
    agent = bundled(env_id)
    mind, spec = agent.explain.mind, agent.spec
    ranges = ranges_by_id(env_id, spec.n_features)
    told = 0
    for state in some_states(agent, 60):
        flips = find_flips_at(mind, state, ranges)
        text = tell_certainty(flips, mind.view.attention, spec)
        radius = flips.certificate.radius
        if radius == 0:
            assert text.startswith("Nothing is certain")
            continue
        told += 1
        for d, feature in enumerate(spec.features):
            alone = radius / mind.view.attention[d]
            assert f"{amount(alone, feature)} of {feature.name}" in text
            for way in (-1, 1):
                there = state.copy()
                there[d] += way * alone * 0.999
                assert mind.act(there) == flips.decision.action
    assert told > 2


def test_where_options_vote_nothing_is_called_certain():
    agent = bundled("CartPole-v1")
    mind = agent.explain.mind
    voting = Mind(replace(mind.config, decide_by=DecideBy.VOTE), mind._state)
    flips = find_flips_at(voting, some_states(agent)[3], ranges_by_id("CartPole-v1", 4))
    text = tell_certainty(flips, mind.view.attention, agent.spec)
    assert text.startswith("Nothing is certain at a distance")


def test_of_an_agent_that_thinks_ahead_flips_are_tried_and_it_says_in_how_many_steps():
    agent = bundled("CartPole-v1")
    mind = agent.explain.mind
    assert isinstance(mind.config, AnticipatingConfig)
    thinking = Mind(replace(mind.config, think_ahead=2), mind._state)
    ranges, state = ranges_by_id("CartPole-v1", 4), some_states(agent)[3]
    flips = find_flips_at(thinking, state, ranges, patience_s=60.0)
    assert flips.steps == 200
    assert flips.nearest is not None
    chosen = thinking.act(state)
    for both in flips.features:
        for flip in (both.less, both.more):
            if flip is None:
                continue
            there = state.copy()
            there[flip.feature] = flip.beyond
            assert thinking.act(there) == flip.action != chosen
            there[flip.feature] = flip.border
            assert thinking.act(there) == chosen
            assert 0 < flip.tolerance == abs(flip.beyond - flip.border)
    text = tell_certainty(flips, mind.view.attention, agent.spec)
    assert text.startswith("Nothing is certain at a distance: it thinks ahead.")
    assert "in 200 steps each way" in text


def test_where_thinking_takes_too_long_to_try_it_says_so():
    mind = bundled("CartPole-v1").explain.mind
    assert isinstance(mind.config, AnticipatingConfig)
    thinking = Mind(replace(mind.config, think_ahead=5), mind._state)
    with pytest.raises(ValueError, match="thinks so far ahead"):
        find_flips_at(thinking, np.zeros(4), ranges_by_id("CartPole-v1", 4), patience_s=1e-6)
