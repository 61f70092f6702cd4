"""The nearest flip of all features: no sampling finds a nearer one, and it can be called off."""

import sys
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.config import PaperConfig
from ao2viz.core.decision import DecideBy
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import Ranges, ranges_of, unlimited
from ao2viz.explain.background import Background
from ao2viz.explain.flips import explain_flips
from ao2viz.explain.nearest import TOLERANCE, find_nearest_flip, tell_nearest
from ao2viz.explain.radius import certify
from tests.explain.agents import BOX, BUNDLED, bundled, hand_made, minds, places, some_states
from tests.forests import cartpole


def sampled_flips(mind: Mind, seen: np.ndarray, ranges: Ranges, reach: float, n: int, seed: int):
    """Distances of those of n random observations, about `reach` away, that flip."""
    rng, attention = np.random.default_rng(seed), mind.view.attention
    action, found = mind.act(seen), []
    for _ in range(n):
        parts = rng.exponential(size=len(seen)) * (rng.random(len(seen)) < 0.7)
        total = parts.sum()
        if total == 0:
            continue
        steps = reach * rng.uniform(0.2, 1.2) * parts / total * rng.choice((-1, 1), len(seen))
        moved = np.divide(steps, attention, out=np.zeros_like(steps), where=attention > 0)
        there = np.clip(seen + moved, ranges.low, ranges.high)
        if mind.act(there) != action:
            found.append(float((attention * np.abs(there - seen)).sum()))
    return found


@settings(deadline=None, max_examples=60)
@given(minds(), places(), st.integers(0, 2**32))
def test_no_sample_flips_nearer(mind: Mind, seen: np.ndarray, seed: int) -> None:
    found = find_nearest_flip(mind, seen, BOX, time_limit_s=20)
    alone = explain_flips(mind, mind.decide(seen), BOX).nearest
    if found.flipped is not None:
        assert BOX.allow(found.flipped)
        assert mind.act(found.flipped) == found.action != mind.act(seen)
        distance = (mind.view.attention * np.abs(found.flipped - seen)).sum()
        assert found.distance == pytest.approx(distance)
        assert found.bound <= found.distance
    assert found.bound >= certify(mind, seen).radius * (1 - TOLERANCE)
    if alone is not None:
        assert found.distance <= alone.distance * (1 + 1e-6) + 1e-9
    reach = found.distance if found.flipped is not None else 6.0
    for distance in sampled_flips(mind, seen, BOX, reach, 400, seed):
        assert distance >= found.bound * (1 - 1e-9)
        if found.is_complete:
            assert distance >= found.distance * (1 - 2 * TOLERANCE) - 1e-9


@pytest.mark.parametrize("env_id", BUNDLED)
def test_none_does_around_trained_agents(env_id: str) -> None:
    agent = bundled(env_id)
    mind, ranges, complete = agent.explain.mind, ranges_of(agent.env), 0
    states = some_states(agent, step=70)[:6]
    for n, seen in enumerate(states):
        found = find_nearest_flip(mind, seen, ranges, time_limit_s=10)
        complete += found.is_complete
        assert certify(mind, seen).radius <= found.bound * (1 + 1e-6)
        for distance in sampled_flips(mind, seen, ranges, found.distance, 1_500, n):
            assert distance >= found.bound * (1 - 1e-9)
    assert complete >= len(states) - 2


def test_what_no_feature_does_alone_two_do_together() -> None:
    mind = hand_made([[0.0, 0.0], [1.0, 1.0]], [[1, 0], [0, 1]])
    seen = np.zeros(2)
    assert explain_flips(mind, mind.decide(seen), unlimited(2)).nearest is None
    found = find_nearest_flip(mind, seen, unlimited(2))
    assert found.is_complete
    assert found.distance == pytest.approx(1.0, rel=1e-3)
    assert found.flipped is not None
    assert (found.flipped > 0).all()
    assert mind.act(found.flipped) == 1


def test_it_goes_around_options_in_between() -> None:
    # Option 2 chooses otherwise, but option 1 lies between: only beyond 1's cell does 2 decide.
    mind = hand_made([[0.0, 0.0], [1.0, 0.0], [1.5, 0.5]], [[1, 0], [1, 0], [0, 1]])
    found = find_nearest_flip(mind, np.zeros(2), unlimited(2))
    assert found.is_complete
    # Left of x = 1 both are equally near, and 1 is the older.
    assert found.distance == pytest.approx(1.5, rel=1e-3)
    for distance in sampled_flips(mind, np.zeros(2), unlimited(2), 2.0, 20_000, 0):
        assert distance >= found.distance * (1 - 2 * TOLERANCE)


def test_where_nothing_flips_it_says_so_or_how_far_it_has_looked() -> None:
    mind = hand_made([[0.0], [3.0]], [[1, 0], [2, 0]])
    found = find_nearest_flip(mind, np.array([0.0]), unlimited(1))
    assert (found.flipped, found.bound, found.is_complete) == (None, np.inf, True)
    assert tell_nearest(found, cartpole()) == ("Whatever is seen, no option chooses otherwise.",)
    mind = hand_made([[0.0], [1.0]], [[1, 0], [0, 1]])
    narrow = Ranges(np.array([-1.0]), np.array([0.4]))
    found = find_nearest_flip(mind, np.array([0.2]), narrow)
    assert (found.flipped, found.is_complete) == (None, True)
    assert "Nothing nearer than a distance of 2.00" in tell_nearest(found, cartpole())[0]


def test_on_the_very_edge_there_is_nothing_to_search() -> None:
    mind = hand_made([[0.0], [1.0]], [[1, 0], [0, 1]])
    found = find_nearest_flip(mind, np.array([0.5]), unlimited(1))
    assert found.is_complete
    assert (found.bound, found.gap) == (0.0, pytest.approx(0.0, abs=1e-9))
    assert found.distance < 1e-12


def hard() -> tuple[Mind, np.ndarray, Ranges]:
    """A state around which the search takes some seconds."""
    agent = bundled("MountainCar-v0")
    episode = agent.episodes[0]
    seen = episode.observations[3 * (len(episode) // 8)]
    return agent.explain.mind, seen, ranges_of(agent.env)


def test_cut_short_it_gives_the_best_so_far_and_the_gap() -> None:
    mind, seen, ranges = hard()
    started = time.monotonic()
    found = find_nearest_flip(mind, seen, ranges, time_limit_s=0.5)
    assert time.monotonic() - started < 3
    assert found.flipped is not None
    assert not found.is_complete
    assert 0 < found.gap < 1
    assert certify(mind, seen).radius <= found.bound * (1 + 1e-6)
    assert "may be nearer by up to" in tell_nearest(found, bundled("MountainCar-v0").spec)[0]


def test_progress_is_told_bounds_only_rise_and_it_can_be_ended() -> None:
    mind, seen, ranges = hard()
    told = []

    def note(state):
        told.append(state)
        return len(told) < 20

    found = find_nearest_flip(mind, seen, ranges, on_progress=note)
    assert len(told) == 20
    assert not found.is_complete
    bounds, distances = [s.bound for s in told], [s.distance for s in told]
    assert bounds == sorted(bounds)
    assert distances == sorted(distances, reverse=True)


def test_in_the_background_it_can_be_watched_and_called_off() -> None:
    agent = bundled("MountainCar-v0")
    _, seen, _ = hard()
    search = agent.explain.nearest_flip_in_background(seen)
    until = time.monotonic() + 20
    while search.latest is None and time.monotonic() < until:
        time.sleep(0.01)
    assert not search.is_done
    with pytest.raises(TimeoutError, match="wait longer, or cancel"):
        search.result(0.01)
    search.cancel()
    found = search.result(10)
    assert search.is_done
    assert not found.is_complete
    assert search.latest is found


def test_an_error_in_the_background_is_raised_where_the_result_is_asked_for() -> None:
    def fail(report):
        raise ValueError("no such luck")

    with pytest.raises(ValueError, match="no such luck"):
        Background(fail).result(5)
    assert threading.active_count() < 20


def test_a_vote_is_refused() -> None:
    mind = hand_made([[0.0]], [[1, 0]], config=replace(PaperConfig(), decide_by=DecideBy.VOTE))
    with pytest.raises(ValueError, match="decides by path"):
        find_nearest_flip(mind, np.zeros(1), unlimited(1))


def test_without_the_solver_it_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy", None)
    mind = hand_made([[0.0]], [[1, 0]])
    with pytest.raises(ValueError, match=r"needs scipy.*pip install 'ao2viz\[explain\]'"):
        find_nearest_flip(mind, np.zeros(1), unlimited(1))


def test_the_nearest_flip_is_told_by_what_changes() -> None:
    values = [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.1, 0.0]]
    mind = hand_made(values, [[1, 0], [0, 1]], [1.0, 1.0, 10.0, 1.0])
    found = find_nearest_flip(mind, np.zeros(4), unlimited(4))
    (told,) = tell_nearest(found, cartpole())
    assert "m more cart position" in told
    assert "° more pole angle: then it chooses push right. That is a distance of 1.00" in told
    assert told.endswith("the least there is.")
