"""Conditions: what can be typed, what is refused, and that nothing that is typed does harm."""

import dataclasses
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.config import AnticipatingConfig
from ao2viz.envs.catalogue import Feature
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.conditions import (
    FLAGS,
    QUANTITIES,
    AllOf,
    AnyOf,
    Compare,
    Condition,
    Flag,
    IsAction,
    Not,
    meets,
)
from ao2viz.explain.typed_conditions import ConditionError, parse_condition
from ao2viz.recording.episode import Episode
from tests.forests import cartpole, decision, no_options, pendulum

CARTPOLE, PENDULUM = cartpole(), pendulum()
CONFIG = AnticipatingConfig()


def odd_task(features: list[str], actions: list[str]) -> TaskSpec:
    """A task of these names, as a file from anybody may hold."""
    return dataclasses.replace(
        CARTPOLE,
        features=tuple(Feature(name, unit) for name, unit in zip(features, "m°//", strict=False)),
        action_names=tuple(actions),
    )


ODD = odd_task(
    ["margin", "x and y", "not-so", "x", "feature 1", "", "a > b", "x velocity"],
    ["left", "go left", "or", "action 0", "go (fast)"],
)
SPECS = st.sampled_from([CARTPOLE, PENDULUM, ODD])
WORDS = [
    *QUANTITIES,
    *FLAGS,
    "pole angle",
    "feature 2",
    "and",
    "or",
    "not",
    "(",
    ")",
    "<",
    ">=",
    "!=",
    "5",
    "1e999",
    "deg",
    "°/s",
    "action",
    "=",
    "left",
    "torque −2",
    "action 1",
]


def episode(n: int = 6) -> Episode:
    decisions = [decision(action=t % 2, explored=t == 1, created=7 if t == 2 else -1)
                 for t in range(n - 1)]  # fmt: skip
    observations = np.zeros((n + 1, 4))
    observations[:, 2] = np.radians(np.arange(n + 1.0))
    return Episode(
        env_id="CartPole-v1",
        seed=1,
        observations=observations,
        actions=np.array([t % 2 for t in range(n)]),
        rewards=np.array([1.0, 1.0, 1.0, 1.0, -9.0, -9.0][:n]),
        decisions=(*decisions, no_options(explored=False)),
        terminated=True,
        truncated=False,
    )


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ("pole angle > 3.5 deg", [4, 5]),
        ("pole angle>3.5°", [4, 5]),
        ("POLE  ANGLE > 3.5", [4, 5]),
        ("feature 2 >= 4", [4, 5]),
        ("explored", [1]),
        ("new option or explored", [1, 2]),
        ("not explored and step < 3", [0, 2]),
        ("not (explored or step >= 3)", [0, 2]),
        ("action = left", [0, 2, 4]),
        ("action != push left and pole angle > 0.5", [1, 3, 5]),
        ("reward < −8", [4, 5]),
        ("reward drop", [4]),
        ("return = 4", [4]),
        ("margin < 0 and not explored", [0, 2, 4]),
        ("step = 1 or step = 3 and explored", [1]),
    ],
)
def test_conditions_find_their_steps(text, steps):
    condition = parse_condition(text, CARTPOLE)
    assert np.flatnonzero(meets(condition, episode(), CARTPOLE, CONFIG)).tolist() == steps


def test_a_number_that_is_not_there_meets_no_comparison():
    for text in ("distance < 1e9", "distance >= -1", "distance != 3"):
        assert not meets(parse_condition(text, CARTPOLE), episode(), CARTPOLE, CONFIG)[-1]


def test_what_was_never_seen_is_what_no_option_stands_for():
    near, far = (
        replace(decision(), path_distances=np.array([[3.0, 2.0, distance], [3.0, 2.0, np.nan]]))
        for distance in (0.1, 0.2)
    )
    shown = replace(episode(2), decisions=(near, far))
    condition = parse_condition("never seen", CARTPOLE)
    assert CONFIG.levels == 3  # So that an option stands for what is within 0.125.
    assert meets(condition, shown, CARTPOLE, CONFIG).tolist() == [False, True]
    assert not meets(condition, shown, CARTPOLE, None).any()


@pytest.mark.parametrize(
    ("text", "at", "expected"),
    [
        ("", 0, "expected one of cart position"),
        ("margn < 0.1", 0, "expected one of cart position"),
        ("margin 0.1", 7, "after margin"),
        ("margin < ten", 9, "expected a number"),
        ("margin < 1e999", 9, "expected a number"),
        ("pole angle > 5 m", 15, "expected ° or nothing after the number, for pole angle"),
        ("margin < 5 deg", 11, "“and”, “or” or the end after the number, for margin"),
        ("action > left", 7, "expected “=” or “!=”"),
        ("action = up", 9, "expected an action: push left, push right"),
        ("(explored", 9, "but there is the end"),
        ("explored)", 8, "“and”, “or” or the end"),
        ("explored and", 12, "expected one of"),
        ("explored tie", 9, "expected “and”, “or” or the end"),
        ("__import__('os')", 0, "expected one of"),
        ("(" * 41 + "tie", 40, "at most 40 brackets"),
        ("not " * 300 + "tie", 1000, "at most 1,000 characters"),
    ],
)
def test_what_is_no_condition_is_refused_with_its_place(text, at, expected):
    with pytest.raises(ConditionError, match="At character") as refused:
        parse_condition(text, CARTPOLE)
    assert refused.value.at == at
    assert expected in str(refused.value)


def test_short_names_work_where_they_name_one_thing():
    assert parse_condition("position > 1", CARTPOLE) == parse_condition(
        "cart position > 1.0 m", CARTPOLE
    )
    with pytest.raises(ConditionError, match="expected one of"):
        parse_condition("velocity > 1", CARTPOLE)  # The cart's, or the pole's?
    for text in ("action = torque −2", "action = -2", "action = torque -2"):
        assert parse_condition(text, PENDULUM) == IsAction(0, True, "torque −2")
    assert parse_condition("action = 2", PENDULUM) == IsAction(4, True, "torque +2")


def test_names_that_mean_something_else_are_given_by_number():
    assert parse_condition("margin < 1", ODD) == Compare("margin", "<", 1.0, "margin")
    assert parse_condition("feature 0 < 1", ODD).shown == "feature 0"
    assert parse_condition("x and y > 1", ODD) == Compare("feature 1", ">", 1.0, "x and y", "°")
    assert parse_condition("action = action 3", ODD) == IsAction(3, True, "action 3")
    assert parse_condition("action = action 0", ODD).action == 0


def test_ten_thousand_features_are_no_burden():
    many = odd_task([], ["go"])
    features = tuple(Feature(f"the sensor {i}") for i in range(10_000))
    many = dataclasses.replace(many, features=features)
    began = time.monotonic()
    assert parse_condition("the sensor 7 > 1", many).name == "feature 7"
    assert parse_condition("feature 9999 > 1", many).name == "feature 9999"
    with pytest.raises(ConditionError, match="expected one of"):
        parse_condition("feature 10000 > 1", many)
    assert time.monotonic() - began < 5.0


@given(st.text(max_size=80) | st.lists(st.sampled_from(WORDS)).map(" ".join), SPECS)
@settings(max_examples=400, deadline=None)
def test_whatever_is_typed_is_a_condition_or_a_clear_error(text, spec):
    refused: ConditionError | None = None
    try:
        condition = parse_condition(text, spec)
    except ConditionError as error:
        refused = error
    else:
        assert parse_condition(str(condition), spec) == condition
    if refused is not None:
        assert 0 <= refused.at <= len(text)
        assert "expected" in str(refused)


def conditions(spec: TaskSpec) -> st.SearchStrategy[Condition]:
    def compared(pair: tuple[str, str, float]) -> Condition:
        return parse_condition(f"{pair[0]} {pair[1]} {pair[2]!r}", spec)

    numbers = st.floats(allow_nan=False, allow_infinity=False)
    names = st.sampled_from([*QUANTITIES, *(f"feature {i}" for i in range(len(spec.features)))])
    actions = st.integers(0, len(spec.action_names) - 1)
    leaves = (
        st.sampled_from(FLAGS).map(Flag)
        | st.tuples(names, st.sampled_from(["<", "<=", ">", ">=", "=", "!="]), numbers).map(
            compared
        )
        | actions.map(lambda i: parse_condition(f"action = action {i}", spec))
    )
    return st.recursive(
        leaves,
        lambda inner: (
            inner.map(Not)
            | st.lists(inner, min_size=2, max_size=3).map(lambda p: AllOf(tuple(p)))
            | st.lists(inner, min_size=2, max_size=3).map(lambda p: AnyOf(tuple(p)))
        ),
        max_leaves=6,
    )


@given(st.data(), SPECS)
@settings(deadline=None)
def test_conditions_survive_being_written_down(data, spec):
    condition = data.draw(conditions(spec))
    assert parse_condition(str(condition), spec) == condition


@given(st.data())
@settings(deadline=None)
def test_and_or_and_not_are_what_they_say(data):
    one, other = (data.draw(conditions(CARTPOLE)) for _ in range(2))
    shown = episode()

    def of(condition: Condition) -> np.ndarray:
        return meets(condition, shown, CARTPOLE, CONFIG)

    np.testing.assert_array_equal(of(Not(one)), ~of(one))
    np.testing.assert_array_equal(of(AllOf((one, other))), of(one) & of(other))
    np.testing.assert_array_equal(of(AnyOf((one, other))), of(one) | of(other))
