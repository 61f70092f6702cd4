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
    FORGET = "learning again without an episode"
    LEDGER = "learning again for a ledger"
    WHOLE = "look at the whole agent"
    MUTE = "episodes without an option"


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
class ExportOption:
    """Writes all that is known of the selected option, for the browser to save."""


@dataclass(frozen=True)
class ChooseForgotten:
    """Which training episode to learn again without; counted from 0."""

    episode: int


@dataclass(frozen=True)
class Forget:
    """Learns again without the chosen training episode, and asks what would be otherwise."""


@dataclass(frozen=True)
class KeepLedger:
    """Learns again, and writes down every reward in the weight that is open."""


@dataclass(frozen=True)
class LookAtWhole:
    """Shows what is known of the whole agent that is watched; counts it first, if so asked."""

    begins: bool


@dataclass(frozen=True)
class ChooseMuted:
    """How many of the options that decide most often to play without, one at a time."""

    options: int


@dataclass(frozen=True)
class ChooseMutedEpisodes:
    """How many episodes to play without each option."""

    episodes: int


@dataclass(frozen=True)
class Mute:
    """Plays the same episodes with all options, and without each of these."""

    options: tuple[int, ...]


@dataclass(frozen=True)
class CallOff:
    """Ends long work; what it has come to stays."""

    task: Task


WhatIfCommand = Suppose | SupposeState | StopSupposing | FindNearest
CompareCommand = ChooseOther | ChooseDuelSeed | Fight | SeekDuel
ExportCommand = ChooseFormat | ChooseScope | Export | ExportOption
LearnAgainCommand = ChooseForgotten | Forget | KeepLedger
WholeCommand = LookAtWhole | ChooseMuted | ChooseMutedEpisodes | Mute
