"""Conditions on the steps of an episode, and which steps meet them.

`typed_conditions` reads them from what people type, and `str` writes them down.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import eq, ge, gt, le, lt, ne

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.moments import Course, MomentKind, course_of
from ao2viz.recording.episode import Episode

QUANTITIES = ("margin", "reward", "return", "step", "distance")
"""What can be compared beside features: `return` is the sum of the rewards before the step."""

TIE = "tie"
FLAGS = (*(kind.value for kind in MomentKind if kind is not MomentKind.END), TIE)
"""What a step is or is not."""

_COMPARE: Mapping[str, Callable[[NDArray, float], NDArray]] = {
    "<": lt,
    "<=": le,
    ">": gt,
    ">=": ge,
    "=": eq,
    "!=": ne,
}


@dataclass(frozen=True)
class Compare:
    """A number of the step against a number, in the unit that people read."""

    name: str  # One of QUANTITIES, or "feature 0" and so on.
    operator: str
    value: float
    shown: str  # The name as people read it, with which it can be typed.
    unit: str = ""

    def __str__(self) -> str:
        unit = self.unit if self.unit.startswith("°") or not self.unit else f" {self.unit}"
        return f"{self.shown} {self.operator} {self.value!r}{unit}"


@dataclass(frozen=True)
class IsAction:
    """Whether the action that was taken is this one."""

    action: int
    is_meant: bool  # False: any other.
    shown: str

    def __str__(self) -> str:
        return f"action {'=' if self.is_meant else '!='} {self.shown}"


@dataclass(frozen=True)
class Flag:
    """Whether the step is marked as such."""

    name: str  # One of FLAGS.

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Not:
    """The opposite."""

    inner: "Condition"

    def __str__(self) -> str:
        return f"not {_in_brackets(self.inner)}"


@dataclass(frozen=True)
class AllOf:
    """Both, or all of several."""

    parts: tuple["Condition", ...]

    def __str__(self) -> str:
        return " and ".join(map(_in_brackets, self.parts))


@dataclass(frozen=True)
class AnyOf:
    """At least one of several."""

    parts: tuple["Condition", ...]

    def __str__(self) -> str:
        return " or ".join(map(_in_brackets, self.parts))


Condition = Compare | IsAction | Flag | Not | AllOf | AnyOf


def _in_brackets(condition: Condition) -> str:
    return f"({condition})" if isinstance(condition, AllOf | AnyOf) else str(condition)


def meets(
    condition: Condition, episode: Episode, spec: TaskSpec, config: Config | None
) -> NDArray[np.bool_]:
    """[T] the steps of an episode that meet a condition.

    A number that is not there, as the distance while there are no options, meets no comparison.
    """
    return _evaluate(condition, _Columns(episode, spec, course_of(episode, config)))


@dataclass(frozen=True, eq=False)
class _Columns:
    episode: Episode
    spec: TaskSpec
    course: Course

    def of(self, name: str) -> NDArray[np.float64]:
        """[T] in the unit that people read."""
        episode, course = self.episode, self.course
        match name:
            case "margin":
                return course.margins
            case "reward":
                return episode.rewards
            case "return":
                return course.returns
            case "step":
                return np.arange(len(episode), dtype=np.float64)
            case "distance":
                return course.distances
            case _:
                d = int(name.removeprefix("feature "))
                return episode.observations[: len(episode), d] * self.spec.features[d].scale


def _evaluate(condition: Condition, columns: _Columns) -> NDArray[np.bool_]:
    match condition:
        case Compare(name, operator, value):
            column = columns.of(name)
            return _COMPARE[operator](column, value) & ~np.isnan(column)
        case IsAction(action, is_meant):
            return (columns.episode.actions == action) == is_meant
        case Flag(name):
            if name == TIE:
                return columns.course.ties
            return columns.course.flags[MomentKind(name)]
        case Not(inner):
            return ~_evaluate(inner, columns)
        case AllOf(parts):
            return np.all([_evaluate(part, columns) for part in parts], axis=0)
        case AnyOf(parts):
            return np.any([_evaluate(part, columns) for part in parts], axis=0)
