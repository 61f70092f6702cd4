"""Flips flip, nothing smaller does, and within the certified radius nothing ever does."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.config import AnticipatingConfig, PaperConfig
from ao2viz.core.decision import DecideBy
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges, ranges_of, unlimited
from ao2viz.explain.flips import FlipKind, bracket_flips, explain_flips, find_flips, tell_flips
from ao2viz.explain.line import scan_line
from ao2viz.explain.radius import certify
from tests.explain.agents import BOX, BUNDLED, bundled, hand_made, minds, places, some_states
from tests.forests import cartpole

# Of a boundary, on both sides of it the agent's own rounding decides.
NEAR = 1e-9


def exactly(value: float) -> float:
    """A number near by, with which distances on a grid are not rounded: ties stay ties there."""
    return round(value * 2**20) / 2**20


def check_flips(mind: Mind, seen: np.ndarray, ranges: Ranges, probes: int) -> None:
    """Asks the agent beyond every flip, and everywhere before it."""
    action = mind.act(seen)
    flips = find_flips(mind, mind.decide(seen), ranges)
    for both in flips:
        for flip, end in ((both.less, both.low), (both.more, both.high)):
            asked = seen.copy()
            reach = np.clip(end, -1e3, 1e3)
            if flip is not None:
                asked[both.feature] = flip.beyond
                assert mind.act(asked) == flip.action != action
                assert ranges.low[both.feature] <= flip.beyond <= ranges.high[both.feature]
                assert flip.change == flip.border - seen[both.feature]
                if flip.kind is not FlipKind.TIE:
                    assert abs(flip.beyond - flip.border) <= 1e-6 * max(1, abs(flip.border))
                reach = flip.border
            span = reach - seen[both.feature]
            for part in np.linspace(0, 1, probes) ** 3:
                asked[both.feature] = exactly(seen[both.feature] + span * part)
                short = NEAR * max(1, abs(reach))
                if (
                    short
                    < (asked[both.feature] - seen[both.feature]) * np.sign(span)
                    < abs(span) - short
                ):
                    assert mind.act(asked) == action, (flip, asked)


@settings(deadline=None, max_examples=300)
@given(minds(), places())
def test_flips_flip_and_nothing_smaller_does(mind: Mind, seen: np.ndarray) -> None:
    check_flips(mind, seen, BOX, probes=40)


@pytest.mark.parametrize("env_id", BUNDLED)
def test_they_do_on_trained_agents(env_id: str) -> None:
    agent = bundled(env_id)
    mind, ranges = agent.explain.mind, ranges_of(agent.env)
    for seen in some_states(agent, step=40):
        check_flips(mind, seen, ranges, probes=200)


@settings(deadline=None, max_examples=200)
@given(minds(), places(), st.integers(0, 2), st.integers(0, 2**32))
def test_a_line_is_told_without_a_gap_and_as_the_agent_acts(mind, seen, feature, seed) -> None:
    pieces = scan_line(mind, seen, feature, BOX)
    assert (pieces[0].start, pieces[-1].end) == (-2.0, 2.0)
    for one, other in itertools.pairwise(pieces):
        assert one.end == other.start
        assert (one.option, one.actions) != (other.option, other.actions)
    rng = np.random.default_rng(seed)
    for piece in pieces:
        asked = seen.copy()
        asked[feature] = exactly(rng.uniform(piece.start, piece.end))
        if min(asked[feature] - piece.start, piece.end - asked[feature]) > NEAR:
            decision = mind.decide(asked)
            assert decision.action in piece.actions
            assert decision.is_tie == (len(piece.actions) > 1)


@settings(deadline=None, max_examples=300)
@given(minds(), places(), st.integers(0, 2**32))
def test_within_the_certified_radius_nothing_changes_the_action(mind, seen, seed) -> None:
    certificate = certify(mind, seen)
    check_radius(mind, seen, certificate.radius, np.random.default_rng(seed), tries=30)
    nearest = explain_flips(mind, mind.decide(seen), BOX).nearest
    assert nearest is None or nearest.distance >= certificate.radius


def check_radius(
    mind: Mind, seen: np.ndarray, radius: float, rng: np.random.Generator, tries: int
) -> None:
    if radius == 0.0:
        return
    action, attention = mind.act(seen), mind.view.attention
    radius = min(radius, 100.0)
    for _ in range(tries):
        # Any direction, also along an axis; the corners of an L1 ball are where it would break.
        parts = rng.exponential(size=len(seen))
        if rng.random() < 0.5:
            parts[np.argsort(parts)[:-1]] = 0.0
        signs = rng.choice((-1, 1), len(seen))
        steps = radius * 0.9999999 * signs * parts / parts.sum()
        moved = np.divide(steps, attention, out=np.zeros_like(steps), where=attention > 0)
        assert mind.act(seen + moved) == action


@pytest.mark.parametrize("env_id", BUNDLED)
def test_radii_of_trained_agents_hold_and_say_something(env_id: str) -> None:
    agent, rng = bundled(env_id), np.random.default_rng(0)
    mind, found = agent.explain.mind, 0
    for seen in some_states(agent, step=15):
        certificate = certify(mind, seen)
        found += certificate.radius > 1e-6
        check_radius(mind, seen, certificate.radius, rng, tries=40)
    assert found > 0.9 * len(some_states(agent, step=15))


def test_the_radius_reaches_past_the_options_own_cell() -> None:
    # The border to 1 is half a unit away, but 1 chooses alike; 2 does not.
    mind = hand_made([[0.0], [1.0], [3.0]], [[1, 0], [1, 0], [0, 1]])
    certificate = certify(mind, np.array([0.0]))
    assert certificate.cell == 0.5
    assert certificate.radius == pytest.approx(1.5)
    assert certificate.option == 2


def test_a_border_between_two_options_is_where_it_flips() -> None:
    mind = hand_made([[0.0, 0.0], [1.0, 0.0]], [[1, 0], [0, 1]], [2.0, 1.0])
    less, more = explain_flips(mind, mind.decide(np.array([0.25, 0.5])), unlimited(2)).features
    assert less.less is None
    assert less.more is not None
    assert less.more.kind is FlipKind.BORDER
    assert (less.more.border, less.more.change, less.more.distance) == (0.5, 0.25, 0.5)
    assert (less.more.option, less.more.action) == (1, 1)
    assert (more.less, more.more) == (None, None)


def test_a_crossing_inside_of_one_options_cell_is_found() -> None:
    grid = np.linspace(-1, 1, 9)
    mind = hand_made(
        [[x] for x in grid], [[x - 0.03, 0.0] for x in grid], [1.0], AnticipatingConfig()
    )
    (both,) = find_flips(mind, mind.decide(np.array([0.1])), unlimited(1))
    assert both.less is not None
    assert both.less.kind is FlipKind.CROSSING
    # The ridge flattens the plane a little.
    ((level, _),), ((slope, _),) = mind.planes([both.less.option])
    assert both.less.border == pytest.approx(-level / slope[0])
    assert both.less.border == pytest.approx(0.03, abs=0.01)
    assert both.more is None


def test_where_a_tie_begins_a_toss_decides_and_may_fall_otherwise() -> None:
    mind = hand_made([[0.0], [1.0]], [[1, 0], [3, 3]])
    (both,) = find_flips(mind, mind.decide(np.array([0.0])), unlimited(1))
    assert both.more is not None
    assert both.more.kind is FlipKind.TIE
    assert both.more.border == 0.5
    assert mind.act(np.array([both.more.beyond])) == 1


def test_a_tie_itself_is_certain_of_nothing() -> None:
    mind = hand_made([[0.0], [1.0]], [[2, 2], [0, 1]])
    assert certify(mind, np.array([0.1])).radius == 0.0
    (both,) = find_flips(mind, mind.decide(np.array([0.1])), unlimited(1))
    assert both.less is not None
    assert both.less.change == 0.0


def test_flips_stay_within_what_the_environment_allows() -> None:
    mind = hand_made([[0.0], [1.0]], [[1, 0], [0, 1]])
    narrow = Ranges(np.array([-1.0]), np.array([0.4]))
    (both,) = find_flips(mind, mind.decide(np.array([0.2])), narrow)
    assert (both.less, both.more) == (None, None)


def test_one_action_alone_never_flips() -> None:
    mind = hand_made([[0.0], [1.0]], [[1], [2]])
    flips = explain_flips(mind, mind.decide(np.array([0.2])), unlimited(1))
    assert flips.nearest is None
    assert flips.certificate is not None
    assert np.isinf(flips.certificate.radius)


@pytest.mark.parametrize("change", [{"decide_by": DecideBy.VOTE}, {"think_ahead": 2}])
def test_votes_and_plans_are_bracketed_to_the_tolerance_that_they_say(change) -> None:
    agent = bundled("CartPole-v1")
    mind = Mind(replace(agent.config, **change), agent.to_saved().state)
    ranges, found = ranges_of(agent.env), 0
    for seen in some_states(agent, step=250):
        decision = mind.decide(seen)
        for both in bracket_flips(mind, decision, ranges, steps=50):
            for flip in (both.less, both.more):
                if flip is None:
                    continue
                found += 1
                assert flip.kind is FlipKind.BRACKETED
                assert 0 < flip.tolerance < 1e-4
                asked = seen.copy()
                asked[both.feature] = flip.beyond
                assert mind.act(asked) == flip.action != decision.action
                asked[both.feature] = flip.border
                assert mind.act(asked) == decision.action
                assert abs(flip.beyond - flip.border) == flip.tolerance
        assert explain_flips(mind, decision, ranges).certificate is None
    assert found > 3


def test_what_is_exact_for_one_path_is_refused_for_a_vote() -> None:
    mind = hand_made([[0.0]], [[1, 0]], config=replace(PaperConfig(), decide_by=DecideBy.VOTE))
    with pytest.raises(ValueError, match="decides by path"):
        scan_line(mind, np.array([0.0]), 0, unlimited(1))
    with pytest.raises(ValueError, match="decides by path"):
        certify(mind, np.array([0.0]))


def test_flips_are_told_with_names_units_and_what_is_certain() -> None:
    mind = hand_made(
        [[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.1, 0.0]], [[1, 0], [0, 1]], [1.0, 1.0, 10.0, 1.0]
    )
    flips = explain_flips(mind, mind.decide(np.zeros(4)), ranges_of(bundled("CartPole-v1").env))
    told = tell_flips(flips, cartpole())
    assert told[0] == "Cart position (0 m): nothing in its range changes the action."
    assert told[2] == "Pole angle (0°): 2.86° more (2.86°) gives push right."
    assert told[4].startswith("Certain: whatever changes, as long as the changes add up to a ")
    assert "less than 0.500," in told[4]
