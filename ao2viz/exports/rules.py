"""A few IF-THEN rules that come close to the agent, and how close, measured as printed.

A shallow decision tree distilled from what the agent decides; the rules are its leaves.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import IO

import numpy as np
from numpy.typing import NDArray

from ao2viz.agent import AO2
from ao2viz.envs.catalogue import Feature
from ao2viz.envs.motion import Motion
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import count, number
from ao2viz.exports.content import Content
from ao2viz.exports.escaping import one_line
from ao2viz.training.loop import evaluation_seed, reset, step

SIZES = (2, 3, 4, 6, 8, 12, 16, 24)
"""Numbers of rules that are tried."""

_FITTED, _CHOSEN, _MEASURED = 10, 5, 5  # Episodes to fit trees, to choose one, to measure it.
_LONGEST = 2_000  # Steps of an episode; a task may set no limit.
_SEED = 977  # Of the evaluation whose episodes these are.
_AS_GOOD = 0.01  # Of two trees that differ by less in agreement, the smaller one is better.

Act = Callable[[NDArray[np.float64]], int]


@dataclass(frozen=True)
class Condition:
    """A feature, as it is shown, lies above `low` and not above `high`."""

    feature: int
    low: float  # −inf: no bound.
    high: float  # inf: no bound.

    def holds(self, shown: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether it does, for states [n, D] in the units in which people read them."""
        values = shown[:, self.feature]
        return (values > self.low) & (values <= self.high)


@dataclass(frozen=True)
class Rule:
    """An action for a part of the states; the parts of all rules do not overlap."""

    conditions: tuple[Condition, ...]
    action: int

    def holds(self, shown: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether all conditions do, for states [n, D] in shown units."""
        found = np.ones(len(shown), np.bool_)
        for condition in self.conditions:
            found &= condition.holds(shown)
        return found


def write_rules(content: Content, stream: IO[bytes]) -> None:
    """The rules in words, with what was measured of them.

    Raises:
        ValueError: If the environment cannot be made.
    """
    spec, agent = content.spec, AO2.from_saved(content.saved, content.env_id)

    def act(seen: NDArray[np.float64]) -> int:
        return agent.decide(seen).action

    seeds = [evaluation_seed(_SEED, i) for i in range(_FITTED + _CHOSEN + _MEASURED)]
    played = []
    for i, seed in enumerate(seeds):
        played.append(_play(agent, act, seed))
        content.progress(0.9 * (i + 1) / len(seeds))
    states = [states for states, _, _ in played]
    actions = [actions for _, actions, _ in played]
    rules = _distil(spec, states, actions)
    unseen, told = (np.concatenate(x[-_MEASURED:]) for x in (states, actions))
    returns = [total for _, _, total in played[-_MEASURED:]]
    by_rules = [
        _play(agent, lambda seen: int(apply(rules, seen[None], spec)[0]), seed)[2]
        for seed in seeds[-_MEASURED:]
    ]
    recorded = [episode.observations[:-1] for _, episode in content.episodes]
    lines = [
        f"Rules that come close to an AO2 agent on {one_line(spec.title)}, "
        f"{one_line(spec.env_id)}.",
        "They are a simplification. What the agent does instead is in its decisions.",
        "",
        f"Agreement with the agent: {_measure(rules, spec, unseen, told)} visited in "
        f"{count(_MEASURED, 'episode')} that the rules were not made from.",
    ]
    if recorded:
        seen = np.concatenate(recorded)
        greedy = np.array([act(state) for state in seen])
        lines.append(f"On what is recorded: {_measure(rules, spec, seen, greedy)}.")
    commonest = np.bincount(told).max() / len(told)
    lines += [
        f"Always the commonest action would agree on {_percent(commonest)}.",
        f"Mean return over those {count(_MEASURED, 'episode')}: "
        f"{number(float(np.mean(by_rules)), 4)} by the rules, "
        f"{number(float(np.mean(returns)), 4)} by the agent.",
        "",
        "Exactly one rule holds in every state; those that hold most often come first.",
        "",
    ]
    shown = to_shown(unseen, spec)
    shares = [float(rule.holds(shown).mean()) for rule in rules]
    for place, i in enumerate(np.argsort([-share for share in shares], kind="stable").tolist()):
        rule, held = rules[i], rules[i].holds(shown)
        right = ""
        if held.any():
            right = f", the agent's choice in {_percent(float((told[held] == rule.action).mean()))}"
        lines.append(f"{place + 1:2}. IF {say_conditions(rule, spec)}")
        lines.append(f"    THEN {one_line(spec.action_names[rule.action])}")
        lines.append(f"    ({_percent(shares[i])} of those states{right})")
    stream.write("\n".join(lines).encode() + b"\n")


def apply(rules: list[Rule], states: NDArray[np.float64], spec: TaskSpec) -> NDArray[np.int64]:
    """The action of the one rule that holds in each state [n, D]."""
    shown = to_shown(states, spec)
    actions = np.full(len(states), -1)
    for rule in rules:
        actions[rule.holds(shown)] = rule.action
    assert (actions >= 0).all()  # The leaves of a tree leave nothing out.
    return actions


def to_shown(states: NDArray[np.float64], spec: TaskSpec) -> NDArray[np.float64]:
    """States [n, D] in the units in which people read them."""
    return states * np.array([feature.scale for feature in spec.features])


def say_conditions(rule: Rule, spec: TaskSpec) -> str:
    """The conditions in words; the numbers are exactly those that are compared."""
    if not rule.conditions:
        return "anything"
    return " AND ".join(_say(c, spec.features[c.feature]) for c in rule.conditions)


def _say(condition: Condition, feature: Feature) -> str:
    name, unit = one_line(feature.name), one_line(feature.unit)
    low, high = (
        f"{bound:.12g}".replace("-", "−") + ("" if unit.startswith("°") else " ") + unit
        for bound in (condition.low, condition.high)
    )
    low, high = low.rstrip(), high.rstrip()
    if np.isinf(condition.low):
        return f"{name} ≤ {high}"
    if np.isinf(condition.high):
        return f"{name} > {low}"
    return f"{low} < {name} ≤ {high}"


def _play(agent: AO2, act: Act, seed: int) -> tuple[NDArray[np.float64], NDArray[np.int64], float]:
    """Plays an episode: states [n, D], actions [n], undiscounted return."""
    motion = Motion(agent.spec, agent.config.action_smoothing)
    seen = reset(agent.env, agent.spec, seed)
    states, actions, total = [], [], 0.0
    for _ in range(_LONGEST):
        states.append(seen)
        actions.append(act(seen))
        seen, reward, terminated, truncated = step(agent.env, agent.spec, motion, actions[-1])
        total += reward
        if terminated or truncated:
            break
    return np.array(states), np.array(actions, np.int64), total


def _distil(
    spec: TaskSpec, states: list[NDArray[np.float64]], actions: list[NDArray[np.int64]]
) -> list[Rule]:
    """The smallest set of rules that is about as good as the best, on episodes to choose by."""
    from sklearn.tree import DecisionTreeClassifier  # noqa: PLC0415 -- an extra.

    fitted, labels = np.concatenate(states[:_FITTED]), np.concatenate(actions[:_FITTED])
    chosen = slice(_FITTED, _FITTED + _CHOSEN)
    judged, told = np.concatenate(states[chosen]), np.concatenate(actions[chosen])
    found = []
    for size in SIZES:
        tree = DecisionTreeClassifier(max_leaf_nodes=size, random_state=0)
        tree.fit(to_shown(fitted, spec), labels)
        rules = _read_leaves(tree)
        found.append((float((apply(rules, judged, spec) == told).mean()), rules))
    best = max(agreement for agreement, _ in found)
    return next(rules for agreement, rules in found if agreement >= best - _AS_GOOD)


def _read_leaves(tree) -> list[Rule]:
    """The leaves of a fitted tree, thresholds rounded as they are printed."""
    inner = tree.tree_
    rules: list[Rule] = []
    waiting: list[tuple[int, dict[int, tuple[float, float]]]] = [(0, {})]
    while waiting:
        node, bounds = waiting.pop()
        if inner.children_left[node] < 0:
            conditions = tuple(Condition(f, *bounds[f]) for f in sorted(bounds))
            # Two thresholds may be rounded to the same number: then nothing lies between.
            if all(c.low < c.high for c in conditions):
                rules.append(Rule(conditions, int(tree.classes_[np.argmax(inner.value[node][0])])))
            continue
        feature = int(inner.feature[node])
        threshold = float(f"{inner.threshold[node]:.3g}")
        low, high = bounds.get(feature, (-np.inf, np.inf))
        below, above = (low, min(high, threshold)), (max(low, threshold), high)
        waiting.append((int(inner.children_right[node]), bounds | {feature: above}))
        waiting.append((int(inner.children_left[node]), bounds | {feature: below}))
    return _merge(rules)


def _merge(rules: list[Rule]) -> list[Rule]:
    """Joins neighbours that differ in one bound only and name the same action."""
    merged = list(rules)
    for i, one in enumerate(merged):
        for j, other in enumerate(merged):
            joined = None if j <= i else _join(one, other)
            if joined is not None:
                rest = [rule for k, rule in enumerate(merged) if k not in {i, j}]
                return _merge([*rest, joined])
    return merged


def _join(one: Rule, other: Rule) -> Rule | None:
    if one.action != other.action:
        return None
    ours, theirs = ({c.feature: c for c in rule.conditions} for rule in (one, other))
    if set(ours) != set(theirs):
        return None
    differing = [f for f in ours if ours[f] != theirs[f]]
    if len(differing) != 1:
        return None
    (f,) = differing
    first, second = sorted((ours[f], theirs[f]), key=lambda c: c.low)
    if first.high != second.low:
        return None
    whole = Condition(f, first.low, second.high)
    rest = [c for g, c in ours.items() if g != f]
    if not (np.isinf(whole.low) and np.isinf(whole.high)):
        rest.append(whole)
    return Rule(tuple(sorted(rest, key=lambda c: c.feature)), one.action)


def _measure(
    rules: list[Rule], spec: TaskSpec, states: NDArray[np.float64], told: NDArray[np.int64]
) -> str:
    agreement = float((apply(rules, states, spec) == told).mean())
    return f"{_percent(agreement)} of {count(len(states), 'state')}"


def _percent(share: float) -> str:
    """Rounded down: never more than it is."""
    return f"{np.floor(1000 * share) / 10:.1f} %"
