"""The rules say of themselves what anyone who reads them can measure again."""

import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from sklearn.tree import DecisionTreeClassifier

import ao2viz
from ao2viz import AO2
from ao2viz.exports import rules as room
from ao2viz.resources import saved_schemas
from ao2viz.training.loop import evaluation_seed
from tests.exports.conftest import Export
from tests.forests import cartpole as cartpole_spec

NUMBER = r"(−?[\d.]+(?:e−?\d+)?)"


def read_rules(text: str, features: tuple) -> list[tuple[list, str]]:
    """The rules as a reader takes them: bounds in shown units, and the action's name."""
    found = []
    for condition, action in re.findall(r"^ *\d+\. IF (.*)\n +THEN (.*)$", text, re.MULTILINE):
        bounds = []
        for part in condition.split(" AND ") if condition != "anything" else []:
            (i,) = [
                i
                for i, f in enumerate(features)
                if re.search(rf"(^| ){re.escape(f.name)} [>≤]", part)
            ]
            rest = part.replace(features[i].name, "NAME").replace(features[i].unit or "\0", "")
            numbers = [float(n.replace("−", "-")) for n in re.findall(NUMBER, rest)]
            if len(numbers) == 2:
                bounds.append((i, *numbers))
            else:
                bounds.append((i, numbers[0], np.inf) if ">" in part else (i, -np.inf, numbers[0]))
        found.append((bounds, action))
    return found


def hold(bounds: list, shown: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.array(
        [all(low < state[i] <= high for i, low, high in bounds) for state in shown], np.bool_
    )


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> tuple[AO2, str]:
    path = saved_schemas() / "MountainCar-v0.ao2"
    out = tmp_path_factory.mktemp("rules") / "rules.txt"
    shares: list[float] = []
    ao2viz.export(path, out, "rules", progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    return AO2.load(path), out.read_text("utf-8")


def test_the_printed_agreement_is_that_of_the_printed_rules(printed: tuple[AO2, str]) -> None:
    agent, text = printed
    rules = read_rules(text, agent.spec.features)
    assert 2 <= len(rules) <= max(room.SIZES)
    states, told = [], []
    for i in range(15, 20):
        episode = agent.record_episode(evaluation_seed(room._SEED, i))
        states += list(episode.observations[:-1])
        told += [agent.spec.action_names[a] for a in episode.actions]
    shown = np.array(states) * [f.scale for f in agent.spec.features]
    held = np.array([hold(bounds, shown) for bounds, _ in rules])
    assert (held.sum(axis=0) == 1).all()  # Exactly one holds.
    said = np.array([action for _, action in rules])[held.argmax(axis=0)]
    agreement = 100 * (said == np.array(told)).mean()
    claimed = re.search(r"Agreement with the agent: ([\d.]+) % of ([\d,]+) states", text)
    assert claimed is not None
    assert int(claimed[2].replace(",", "")) == len(states)
    assert float(claimed[1]) == pytest.approx(agreement, abs=0.1)
    assert float(claimed[1]) <= agreement
    assert agreement > 90


def test_rules_by_which_nothing_is_gained_say_so(printed: tuple[AO2, str]) -> None:
    _, text = printed
    assert "They are a simplification." in text
    assert re.search(r"Always the commonest action would agree on [\d.]+ %", text)
    assert re.search(r"Mean return over those 5 episodes: .* by the rules, .* by the agent", text)


def test_hostile_names_stay_in_their_line(tiny, write: Export) -> None:
    text = write(tiny, "rules").read_text("utf-8")
    assert "<script>alert(1)</script>" in text
    assert all(line.isprintable() for line in text.splitlines())


def test_without_its_environment_there_are_no_rules(
    cartpole, write: Export, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match="Could not make the environment 'Nowhere-v7'"):
        write(cartpole, "rules", env="Nowhere-v7")
    assert list(tmp_path.iterdir()) == []


@given(st.integers(0, 10_000), st.integers(2, 24))
def test_exactly_one_rule_holds_anywhere(seed: int, leaves: int) -> None:
    rng = np.random.default_rng(seed)
    states = rng.normal(size=(200, 4)) * rng.uniform(1e-3, 1e3, 4)
    tree = DecisionTreeClassifier(max_leaf_nodes=leaves, random_state=0)
    tree.fit(states, rng.integers(0, 3, 200))
    rules = room._read_leaves(tree)
    spec = cartpole_spec()
    shown = np.concatenate([states, rng.normal(size=(500, 4)) * 1e4])
    assert (np.array([rule.holds(shown) for rule in rules]).sum(axis=0) == 1).all()
    assert len({room.say_conditions(rule, spec) for rule in rules}) == len(rules)


def test_the_act_of_rules_is_the_one_that_holds() -> None:
    spec = cartpole_spec()
    condition = partial(room.Condition, 2)  # The pole's angle, shown in degrees.
    rules = [
        room.Rule((condition(-np.inf, 1.5),), 0),
        room.Rule((condition(1.5, np.inf),), 1),
    ]
    states = np.zeros((2, 4))
    states[1, 2] = np.radians(1.6)
    assert room.apply(rules, states, spec).tolist() == [0, 1]
    assert room.say_conditions(rules[1], spec) == "pole angle > 1.5°"
    assert room.say_conditions(room.Rule((), 0), spec) == "anything"
