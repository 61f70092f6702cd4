"""What a person can ask beyond what happened: what if, beside another agent, as a file.

These are commands as those of `commands`, each one click.
"""

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from ao2viz.exports.formats import Format, Scope


class Task(Enum):
    """What may take long; of each kind a browser has one at a time."""

    NEAREST = "search for the nearest flip"
    BESIDE = "comparison"
    DUEL = "episodes from the same seed"
    EXPORT = "export"


@dataclass(frozen=True)
class Suppose:
    """Supposes another value of one feature, in the environment's units."""

    feature: int
    value: float


@dataclass(frozen=True)
class SupposeState:
    """Supposes another state: a value for each feature, in the environment's units."""

    state: tuple[float, ...]


@dataclass(frozen=True)
class StopSupposing:
    """Returns to what is seen at the moment that is watched."""


@dataclass(frozen=True)
class FindNearest:
    """Searches for the least change of all features together that changes the action."""


@dataclass(frozen=True)
class ChooseOther:
    """Puts another saved agent beside the one that is watched; None: no other."""

    path: Path | None


@dataclass(frozen=True)
class ChooseDuelSeed:
    """From which seed both agents are to play."""

    seed: int


@dataclass(frozen=True)
class Fight:
    """Lets both agents play from the same seeds."""


@dataclass(frozen=True)
class SeekDuel:
    """Shows a step of the two episodes from the same seed."""

    step: int


@dataclass(frozen=True)
class ChooseFormat:
    """As what to export."""

    format: Format


@dataclass(frozen=True)
class ChooseScope:
    """How much to export."""

    scope: Scope


@dataclass(frozen=True)
class Export:
    """Writes what was chosen, for the browser to save."""


@dataclass(frozen=True)
class CallOff:
    """Ends long work; what it has come to stays."""

    task: Task


WhatIfCommand = Suppose | SupposeState | StopSupposing | FindNearest
CompareCommand = ChooseOther | ChooseDuelSeed | Fight | SeekDuel
ExportCommand = ChooseFormat | ChooseScope | Export
