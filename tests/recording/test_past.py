"""The past: the forest of a moment is the one that a fresh run has at that moment."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz import AO2
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.core.growth import GrowthEvent, GrowthKind
from ao2viz.core.mind import Mind
from ao2viz.recording.growth_log import GrowthLog, snapshot_arrays
from ao2viz.recording.past import Past, find_depths, make_past
from ao2viz.recording.snapshots import MAX_BYTES, MAX_SNAPSHOTS, Snapshots
from tests.forests import random_view

QUICK = {"warmup_steps": 50, "levels": 2}


def past_of(agent: AO2) -> Past:
    return make_past(
        agent.forest, agent.num_timesteps, agent.growth.to_arrays(), agent.growth.dropped
    )


def watched(agent: AO2, steps: int) -> dict[int, ForestView]:
    """Trains step by step; the forest at steps after which no episode begins."""
    seen: dict[int, ForestView] = {}
    stepper = agent.stepper()
    for _ in range(steps):
        if not stepper.step().has_ended and agent.num_timesteps % 37 == 0:
            seen[agent.num_timesteps] = agent.forest
    agent.settle()
    return seen


@pytest.mark.parametrize(
    ("env_id", "preset", "more"),
    [
        ("CartPole-v1", "anticipating", QUICK),
        ("CartPole-v1", "anticipating", {**QUICK, "cleansing": 0.5}),
        ("Pendulum-v1", "anticipating", QUICK),
        ("Pendulum-v1", "paper", {"threshold": 0.95}),
    ],
)
def test_every_moment_is_what_a_fresh_run_had_then(env_id, preset, more):
    agent = AO2(env_id, preset, seed=3, **more)
    seen = watched(agent, 2_000)
    past = past_of(agent)
    assert past.is_whole
    assert len(seen) > 20
    for step, view in seen.items():
        then = past.at(step).view
        n = len(view.parents)
        np.testing.assert_array_equal(then.is_alive[:n], view.is_alive)
        assert not then.is_alive[n:].any()
        alive = view.is_alive
        for name in ("parents", "depths", "values", "born"):
            np.testing.assert_array_equal(
                getattr(then, name)[:n][alive], getattr(view, name)[alive]
            )
    if preset == "anticipating":
        kinds = {event.kind for event in agent.growth}
        assert {GrowthKind.REMOVED, GrowthKind.MOVED} <= kinds, "Nothing was regrown."


def test_from_the_last_step_on_it_is_the_forest_of_now():
    agent = AO2("CartPole-v1", seed=0, **QUICK).learn(300)
    past = past_of(agent)
    assert past.at(300).view is past.now
    assert past.at(10**9).step == 300
    assert len(past.at(0).view) == 0


def test_weights_are_those_of_the_snapshot_before_and_decide_as_the_agent_did():
    agent = AO2("CartPole-v1", seed=1, **QUICK)
    stepper, known = agent.stepper(), {}
    for _ in range(1_500):
        has_ended = stepper.step().has_ended
        if agent.num_timesteps == 1_024:
            assert not has_ended  # Otherwise the next episode's beginning would belong to it.
            known["view"] = agent.forest
    past = past_of(agent)
    assert [snapshot.step for snapshot in past.snapshots] == [256, 512, 768, 1024, 1280]
    moment = past.at(1_100)
    assert (moment.step, moment.snapshot) == (1_100, 1_024)
    then, view = past.at(1_024).view, known["view"]
    n = len(view.parents)
    np.testing.assert_array_equal(then.attention, view.attention)
    np.testing.assert_allclose(then.weights[:n], view.weights, rtol=1e-6)
    np.testing.assert_array_equal(then.visits[:n], view.visits)
    fresh = AO2("CartPole-v1", seed=1, **QUICK)
    stepper = fresh.stepper()
    for _ in range(1_024):
        stepper.step()
    mind = Mind.from_view(then, agent.config)
    for state in agent.record_episode(5).observations[:50]:
        now, was = mind.decide(state), fresh.decide(state)
        np.testing.assert_array_equal(now.path, was.path)
        np.testing.assert_allclose(now.action_values, was.action_values, rtol=1e-4)
        if was.margin > 1e-3:
            assert now.action == was.action
    assert past.at(100).snapshot is None
    assert not past.at(100).view.weights.any()


def test_an_older_log_has_structure_only():
    agent = AO2("CartPole-v1", seed=0, **QUICK).learn(600)
    arrays = {n: a for n, a in agent.growth.to_arrays().items() if not n.startswith("snapshot_")}
    past = make_past(agent.forest, 600, arrays, 0)
    assert past.is_whole
    assert past.at(500).snapshot is None
    assert len(past.at(500).view) == len(past_of(agent).at(500).view) > 0
    assert not make_past(agent.forest, 600, arrays, 5).is_whole


def test_every_option_there_ever_was_has_its_last_place():
    agent = AO2("CartPole-v1", seed=3, **QUICK).learn(2_000)
    ever, now = past_of(agent).ever, agent.forest
    assert ever.is_alive.all()
    assert not now.is_alive.all()
    np.testing.assert_array_equal(ever.parents[now.is_alive], now.parents[now.is_alive])
    np.testing.assert_array_equal(ever.depths[now.is_alive], now.depths[now.is_alive])


def view_of(n: int, actions: int = 2) -> ForestView:
    return random_view(n, roots=1, n_actions=actions)


@given(st.integers(1, 3_000), st.integers(1, 400))
@settings(max_examples=40, deadline=None)
def test_snapshots_are_bounded_and_spread_over_the_whole_life(steps, options):
    snapshots, view = Snapshots(), view_of(options)
    for step in range(0, 16 * steps, 16):
        if snapshots.is_due(step):
            snapshots.take(view, step)
    kept = [snapshot.step for snapshot in snapshots.kept]
    assert len(kept) <= MAX_SNAPSHOTS
    assert sum(snapshot.n_bytes for snapshot in snapshots.kept) <= MAX_BYTES
    assert kept == list(range(snapshots.stride, 16 * steps, snapshots.stride))


def test_a_forest_too_big_for_one_snapshot_has_none():
    snapshots, view = Snapshots(), view_of(400, actions=400)
    for _ in range(3):
        snapshots.take(view, snapshots.stride)
    assert len(snapshots) == 0


def test_snapshots_come_back_exactly_and_go_on_alike():
    log = GrowthLog()
    for step in range(256, 256 * 50, 256):
        if log.snapshots.is_due(step):
            log.snapshots.take(view_of(3 + step // 256), step)
    again = GrowthLog.from_arrays(log.to_arrays())
    assert again.snapshots.stride == log.snapshots.stride > 256
    for one, other in zip(log.snapshots.kept, again.snapshots.kept, strict=True):
        assert one.step == other.step
        np.testing.assert_array_equal(one.weights, other.weights)
        np.testing.assert_array_equal(one.visits, other.visits)
    assert not again.snapshots.is_due(log.snapshots.kept[-1].step)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("steps", lambda a: a[::-1]),
        ("rows", lambda a: a + 1),
        ("rows", lambda a: -a),
        ("weights", lambda a: a * np.float32(np.nan)),
        ("weights", lambda a: a.astype(np.float64)),
        ("visits", lambda a: a[:-1]),
        ("visits", lambda a: a - 99),
        ("attention", lambda a: -a),
        ("stride", lambda a: a * 0),
        ("stride", lambda a: a[None]),
    ],
)
def test_snapshots_that_cannot_be_are_refused(name, change):
    log = GrowthLog()
    for step in (256, 512):
        log.snapshots.take(view_of(step // 64), step)
    arrays = log.to_arrays()
    arrays[f"snapshot_{name}"] = change(arrays[f"snapshot_{name}"])
    with pytest.raises(ValueError, match="snapshots"):
        GrowthLog.from_arrays(arrays)
    assert set(snapshot_arrays(arrays)) == {
        "stride", "steps", "rows", "attention", "weights", "visits"
    }  # fmt: skip


def test_a_log_of_another_forest_is_refused():
    log = GrowthLog()
    log.extend([GrowthEvent(0, GrowthKind.CREATED, 9, NO_OPTION)])
    with pytest.raises(ValueError, match="growth log of the 3 options"):
        make_past(view_of(3), 1, log.to_arrays(), 0)
    with pytest.raises(ValueError, match="in a circle"):
        find_depths(np.array([1, 0]), np.array([True, True]))
