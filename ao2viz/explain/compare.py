"""Two agents of one task beside each other: their forests and their settings.

A global, contrastive explanation. Where their actions differ is `whole.compare_minds`.
"""

from dataclasses import dataclass, fields
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config, preset_of
from ao2viz.core.mind import Mind
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.whole import radius_of
from ao2viz.explain.words import number

# A weight counts as another one beyond this part of the greatest weight.
_EQUAL = 1e-9


class Difference(Enum):
    """How an option differs between two forests; the values are what people read."""

    ONLY_HERE = "options only here"
    ONLY_THERE = "options only there"
    TURNED = "options that prefer another action there"
    REWEIGHTED = "options weighted otherwise there"


@dataclass(frozen=True)
class OptionDifference:
    """One option that differs."""

    kind: Difference
    here: int  # Its id in the first forest; for one that is only there the most similar one.
    there: int  # Its id in the second; for one that is only here the most similar one.
    size: float  # Visits of an option that is in one forest only; else the greatest change.
    action_here: int  # What each prefers.
    action_there: int


@dataclass(frozen=True)
class ForestDiff:
    """What is in one forest and not in the other, or weighted otherwise."""

    is_by_id: bool  # Matched by id: one agent at two times. Else by where they stand.
    same: int  # In both, with the same weights.
    counts: dict[Difference, int]
    differences: tuple[OptionDifference, ...]  # Of each kind the greatest first.

    def of(self, kind: Difference) -> tuple[OptionDifference, ...]:
        """Those of one kind, the greatest first."""
        return tuple(one for one in self.differences if one.kind is kind)


def diff_forests(one: Mind, other: Mind) -> ForestDiff:
    """Compares the options of two agents of the same task.

    Where most ids stand for the same option, one agent is seen at two times, and options are
    matched by id. Otherwise two match if each is the other's most similar one, and not further
    away than an option reaches.

    Raises:
        ValueError: If the two do not have the same features and actions.
    """
    shapes = [mind.view.values.shape[1:] + mind.view.weights.shape[1:] for mind in (one, other)]
    if shapes[0] != shapes[1]:
        raise ValueError(
            f"Expected two agents of the same task, but one has {shapes[0][0]} features and "
            f"{shapes[0][1]} actions, the other {shapes[1][0]} and {shapes[1][1]}."
        )
    here, there = np.flatnonzero(one.view.is_alive), np.flatnonzero(other.view.is_alive)
    pairs = _match_ids(one, other)
    is_by_id = 2 * len(pairs) > min(len(here), len(there))
    if not is_by_id:
        pairs = _match_places(one, other, here, there)
    found = [*_alone(one, other, np.setdiff1d(here, pairs[:, 0]), Difference.ONLY_HERE)]
    found += _alone(other, one, np.setdiff1d(there, pairs[:, 1]), Difference.ONLY_THERE)
    changed = _changed(one, other, pairs)
    found += changed
    found.sort(key=lambda d: (list(Difference).index(d.kind), -d.size, d.here))
    counts = {kind: sum(d.kind is kind for d in found) for kind in Difference}
    return ForestDiff(is_by_id, len(pairs) - len(changed), counts, tuple(found))


def _match_ids(one: Mind, other: Mind) -> NDArray[np.int64]:
    """[P, 2] ids that stand for the same option in both."""
    n = min(len(one.view.parents), len(other.view.parents))
    is_same = one.view.is_alive[:n] & other.view.is_alive[:n]
    is_same &= (one.view.values[:n] == other.view.values[:n]).all(axis=1)
    is_same &= one.view.born[:n] == other.view.born[:n]
    return np.column_stack([np.flatnonzero(is_same)] * 2)


def _match_places(
    one: Mind, other: Mind, here: NDArray[np.int64], there: NDArray[np.int64]
) -> NDArray[np.int64]:
    """[P, 2] options that are each other's most similar one, within reach."""
    mine = {i: _nearest(other, one.view.values[i]) for i in here.tolist()}
    theirs = {j: _nearest(one, other.view.values[j])[0] for j in there.tolist()}
    reach = radius_of(other)
    pairs = [(i, j) for i, (j, far) in mine.items() if far <= reach and theirs.get(j) == i]
    return np.array(pairs, np.int64).reshape(-1, 2)


def _nearest(mind: Mind, value: NDArray[np.float64]) -> tuple[int, float]:
    ids, distances = mind.forest.nearest(value)
    return (int(ids[0]), float(distances[0])) if len(ids) else (-1, np.inf)


def _alone(
    mind: Mind, other: Mind, options: NDArray[np.int64], kind: Difference
) -> list[OptionDifference]:
    best, theirs = mind.view.best_actions, other.view.best_actions
    found = []
    for option in options.tolist():
        near = _nearest(other, mind.view.values[option])[0]
        ids = (option, near) if kind is Difference.ONLY_HERE else (near, option)
        actions = int(best[option]), int(theirs[near]) if near >= 0 else int(best[option])
        if kind is Difference.ONLY_THERE:
            actions = actions[::-1]
        visits = float(mind.view.visits[option].sum())
        found.append(OptionDifference(kind, *ids, visits, *actions))
    return found


def _changed(one: Mind, other: Mind, pairs: NDArray[np.int64]) -> list[OptionDifference]:
    mine, theirs = one.view.weights[pairs[:, 0]], other.view.weights[pairs[:, 1]]
    change = np.abs(mine - theirs).max(axis=1, initial=0.0)
    scale = np.maximum(np.abs(mine), np.abs(theirs)).max(initial=0.0)
    found = []
    for place in np.flatnonzero(change > _EQUAL * scale).tolist():
        here, there = pairs[place].tolist()
        actions = one.view.best_action_of(here), other.view.best_action_of(there)
        kind = Difference.REWEIGHTED if actions[0] == actions[1] else Difference.TURNED
        found.append(OptionDifference(kind, here, there, float(change[place]), *actions))
    return found


@dataclass(frozen=True)
class Setting:
    """A setting that two agents do not share; None: the other preset has no such setting."""

    name: str
    here: str | None
    there: str | None


def diff_settings(one: Config, other: Config) -> tuple[Setting, ...]:
    """The settings that differ, the preset first if it does."""
    found = []
    presets = preset_of(one).value, preset_of(other).value
    if presets[0] != presets[1]:
        found.append(Setting("preset", *presets))
    names = dict.fromkeys(field.name for config in (one, other) for field in fields(config))
    for name in names:
        here, there = (_say(config, name) for config in (one, other))
        if here != there:
            found.append(Setting(name, here, there))
    return tuple(found)


def _say(config: Config, name: str) -> str | None:
    value = vars(config).get(name)
    if isinstance(value, Enum):
        return str(value.value)
    return None if value is None else str(value)


def tell_difference(told: OptionDifference, spec: TaskSpec) -> str:
    """One option in a few words."""
    here, there = spec.action_names[told.action_here], spec.action_names[told.action_there]
    match told.kind:
        case Difference.ONLY_HERE:
            return f"{told.here} · {here}, {told.size:,.0f} visits"
        case Difference.ONLY_THERE:
            return f"{told.there} there, near {told.here} · {there}, {told.size:,.0f} visits"
        case Difference.TURNED:
            return f"{told.here} · {here}, there {there}: by {number(told.size)}"
        case Difference.REWEIGHTED:
            return f"{told.here} · {here}: by {number(told.size)}"


def tell_forests(told: ForestDiff) -> str:
    """How much of the forests is the same."""
    n = told.counts
    how = "by id, as one agent at two times" if told.is_by_id else "by where they stand"
    return (
        f"Options are matched {how}. {n[Difference.ONLY_HERE]:,} are only here, "
        f"{n[Difference.ONLY_THERE]:,} only there; of those in both {told.same:,} weigh the same, "
        f"{n[Difference.TURNED] + n[Difference.REWEIGHTED]:,} otherwise, and "
        f"{n[Difference.TURNED]:,} of these prefer another action."
    )
