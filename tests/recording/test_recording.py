import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from ao2viz import AO2
from ao2viz.core.decision import DecideBy
from ao2viz.core.growth import GrowthEvent, GrowthKind
from ao2viz.recording.episode import pack_decisions, unpack_decisions
from ao2viz.recording.growth_log import GrowthLog
from ao2viz.recording.history import EpisodeSummary, History
from tests.forests import decision, plan


@pytest.mark.parametrize("think_ahead", [0, 2])
@pytest.mark.parametrize("decide_by", DecideBy)
def test_packed_decisions_come_back_exactly(decide_by, think_ahead):
    agent = AO2("CartPole-v1", warmup_steps=50, decide_by=decide_by).learn(200)
    agent.set_think_ahead(think_ahead)
    decisions = agent.record_episode(3).decisions
    again = unpack_decisions(pack_decisions(decisions, 4, 2))
    assert len(again) == len(decisions) > 5
    assert any(one.plan is not None for one in decisions) == (think_ahead > 0)
    for one, other in zip(decisions, again, strict=True):
        assert_same_record(replace(one, plan=None), replace(other, plan=None))
        assert (one.plan is None) == (other.plan is None)
        if one.plan is not None and other.plan is not None:
            assert_same_record(one.plan, other.plan)


def test_decisions_that_thought_and_that_did_not_pack_together():
    empty = np.empty(0, np.int64)
    short = plan(
        actions=empty,
        states=np.empty((0, 4)),
        rewards=np.empty(0),
        continues=np.empty(0),
        options=empty,
    )
    made = [decision(plan=plan()), decision(), decision(plan=short)]
    again = unpack_decisions(pack_decisions(made, 4, 2))
    assert again[1].plan is None
    for one, other in ((made[0].plan, again[0].plan), (short, again[2].plan)):
        assert one is not None
        assert other is not None
        assert_same_record(one, other)


def assert_same_record(one, other):
    for field in dataclasses.fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        assert np.array_equal(
            a, b, equal_nan=isinstance(a, float) or field.name == "path_distances"
        ), field.name
        if isinstance(a, np.ndarray):
            assert (a.shape, a.dtype) == (b.shape, b.dtype), field.name


def test_no_decisions_pack_to_nothing():
    assert unpack_decisions(pack_decisions((), 4, 2)) == ()


def test_history_keeps_every_episode():
    history = History()
    rows = [EpisodeSummary(10 * i, -0.5 * i, 10, i) for i in range(200)]
    for row in rows:
        history.append(row)
    assert len(history) == 200
    assert history.summaries == rows
    again = History.from_array(history.to_array())
    again.append(EpisodeSummary(9999, 1.0, 1, 1))
    assert again.summaries[:-1] == rows
    assert len(history) == 200


def _event(n: int) -> GrowthEvent:
    return GrowthEvent(n, GrowthKind(n % 5), n, n - 1)


def test_growth_log_gives_back_what_it_got():
    log = GrowthLog()
    events = [_event(n) for n in range(3000)]
    log.extend(events[:1500])
    log.extend(events[1500:])
    assert list(log) == events
    assert list(GrowthLog.from_arrays(log.to_arrays())) == events
    assert log.dropped == 0


def test_growth_log_drops_the_oldest_when_full():
    log = GrowthLog(max_events=2000)
    log.extend(_event(n) for n in range(7001))
    assert len(log) <= 2000
    assert log.dropped + len(log) == 7001
    assert list(log)[-1] == _event(7000)
    assert [event.step for event in log] == list(range(log.dropped, 7001))


@pytest.mark.parametrize(
    ("column", "values"),
    [
        ("kind", [0, 9]),
        ("option", [-2, 0]),
        ("parent", [0, -5]),
        ("step", [4, 3]),
        ("step", [-1, 0]),
    ],
)
def test_growth_that_cannot_be_is_refused(column, values):
    arrays = {"step": [0, 1], "kind": [0, 0], "option": [0, 1], "parent": [-1, 0]} | {
        column: values
    }
    with pytest.raises(ValueError, match="known kinds, in the order of their steps"):
        GrowthLog.from_arrays({name: np.array(values) for name, values in arrays.items()})


def test_growth_columns_of_different_length_are_refused():
    arrays = GrowthLog().to_arrays() | {"option": np.zeros(1, np.int32)}
    with pytest.raises(ValueError, match="equally long"):
        GrowthLog.from_arrays(arrays)
