"""Two agents beside each other: options that came, went or weigh otherwise, and settings."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from ao2viz.core.config import AnticipatingConfig, PaperConfig
from ao2viz.core.mind import Mind
from ao2viz.explain.compare import (
    Difference,
    diff_forests,
    diff_settings,
    tell_difference,
    tell_forests,
)
from tests.explain.agents import bundled, hand_made, minds

CONFIG = AnticipatingConfig(levels=1)  # An option reaches a distance of a half.


def counts(one, other) -> dict[Difference, int]:
    return diff_forests(one, other).counts


@given(minds())
@settings(deadline=None, max_examples=40)
def test_an_agent_differs_in_nothing_from_itself(mind):
    found = diff_forests(mind, mind.copy())
    assert found.differences == ()
    assert found.same == len(mind.view)
    assert found.is_by_id


@given(minds(), minds())
@settings(deadline=None, max_examples=40)
def test_every_option_of_both_is_counted_once(one, other):
    if one.forest.n_actions != other.forest.n_actions:
        with pytest.raises(ValueError, match="same task"):
            diff_forests(one, other)
        return
    found = diff_forests(one, other)
    n = found.counts
    both = found.same + n[Difference.TURNED] + n[Difference.REWEIGHTED]
    assert both + n[Difference.ONLY_HERE] == len(one.view)
    assert both + n[Difference.ONLY_THERE] == len(other.view)
    for kind in Difference:
        sizes = [difference.size for difference in found.of(kind)]
        assert len(sizes) == n[kind]
        assert sizes == sorted(sizes, reverse=True)


def test_a_later_checkpoint_has_more_options_and_other_weights():
    one = hand_made([[0, 0], [1, 0], [2, 0]], [[1, 0], [1, 0], [1, 0]], config=CONFIG)
    later = hand_made(
        [[0, 0], [1, 0], [2, 0], [9, 9]], [[1, 0], [1, 2], [3, 0], [0, 1]], config=CONFIG
    )
    found = diff_forests(one, later)
    assert found.is_by_id
    assert found.same == 1
    (new,), (turned,), (other,) = (
        found.of(kind) for kind in (Difference.ONLY_THERE, Difference.TURNED, Difference.REWEIGHTED)
    )
    assert (new.there, new.here, new.action_there) == (3, 2, 1)
    assert (turned.here, turned.size, turned.action_here, turned.action_there) == (1, 2, 0, 1)
    assert (other.here, other.size) == (2, 2)
    assert diff_forests(later, one).counts[Difference.ONLY_HERE] == 1


def test_options_of_another_agent_match_where_they_stand_if_within_reach():
    one = hand_made([[0, 0], [5, 0], [9, 9]], [[1, 0]] * 3, config=CONFIG)
    other = hand_made([[5.1, 0], [0.2, 0], [9, 8]], [[1, 0], [0, 1], [1, 0]], config=CONFIG)
    found = diff_forests(one, other)
    assert not found.is_by_id
    assert found.same == 1
    assert [(d.here, d.there) for d in found.of(Difference.TURNED)] == [(0, 1)]
    assert [d.here for d in found.of(Difference.ONLY_HERE)] == [2]
    assert [d.there for d in found.of(Difference.ONLY_THERE)] == [2]


def test_what_differs_is_told_in_words():
    agent = bundled("CartPole-v1")
    mind = agent.explain.mind
    state = dict(mind._state)
    state["weights"] = state["weights"].copy()
    changed = int(np.flatnonzero(mind.view.is_alive)[3])
    state["weights"][changed] = [0.0, 500.0]
    found = diff_forests(mind, Mind(mind.config, state))
    assert len(found.differences) == 1
    text = tell_difference(found.differences[0], agent.spec)
    assert text.startswith(f"{changed} · ")
    told = tell_forests(found)
    assert "0 are only here, 0 only there" in told
    assert f"{len(mind.view) - 1:,} weigh the same, 1 otherwise" in told


def test_only_settings_that_differ_are_listed():
    one = AnticipatingConfig()
    assert diff_settings(one, replace(one)) == ()
    (found,) = diff_settings(one, replace(one, gamma=0.9))
    assert (found.name, found.here, found.there) == ("gamma", "0.995", "0.9")
    names = {setting.name: setting for setting in diff_settings(one, PaperConfig())}
    assert (names["preset"].here, names["preset"].there) == ("anticipating", "paper")
    assert names["threshold"].here is None
