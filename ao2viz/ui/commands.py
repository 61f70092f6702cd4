"""What a person can ask of the dashboard; each click becomes exactly one of these."""

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from ao2viz.core.decision import DecideBy
from ao2viz.figures.charts import Over
from ao2viz.figures.coloring import Coloring
from ao2viz.ui.appearance import AppearanceCommand
from ao2viz.ui.dialog_commands import DialogCommand, NextStage
from ao2viz.ui.look import Arrangement
from ao2viz.ui.questions import (
    CallOff,
    CompareCommand,
    ExportCommand,
    LearnAgainCommand,
    WhatIfCommand,
    WholeCommand,
)
from ao2viz.ui.replay_commands import ReplayCommand, ShowLink


class Transport(Enum):
    """The buttons below the picture."""

    FIRST = "first step"
    BACK = "one step back"
    PLAY = "play or pause"
    FORWARD = "one step forward"
    LAST = "last step"


class RunButton(Enum):
    """The buttons that act on the training run, which all browsers share."""

    START = "start"
    TRAIN_ON = "train on"
    PAUSE = "pause or go on"
    STEP = "one step"
    EPISODE = "one episode"
    STOP = "stop"
    SAVE = "save"


class Table(Enum):
    """What can be taken away as a table; the values are what people read."""

    TRAINING = "training episodes"
    EPISODE = "steps of this episode"
    OPTION = "weights of the selected option"
    LEARNERS = "learning curves of the paper's learners"


class Way(Enum):
    """From an option to one of those around it."""

    PARENT = "its parent"
    CHILD = "its child that was visited the most"
    BEFORE = "the sibling before"
    AFTER = "the sibling after"


class Field(Enum):
    """What is filled in before a run starts or is saved."""

    ENV = "environment"
    CUSTOM_ENV = "other environment"
    PRESET = "preset"
    SEED = "seed"
    STEPS = "steps"
    FILE_NAME = "file name"


@dataclass(frozen=True)
class Move:
    """Moves the replay."""

    to: Transport


@dataclass(frozen=True)
class Seek:
    """Shows a step of the episode."""

    step: int


@dataclass(frozen=True)
class ChooseSource:
    """Watches a saved agent, or with None the training run."""

    path: Path | None


@dataclass(frozen=True)
class ChooseEpisode:
    """Plays another recorded episode from its beginning."""

    index: int


@dataclass(frozen=True)
class Pick:
    """A click on the canvas: selects the option under it, if there is one."""

    origin: tuple[float, float, float]
    direction: tuple[float, float, float]


@dataclass(frozen=True)
class Select:
    """Selects an option by id; NO_OPTION selects nothing."""

    option: int


@dataclass(frozen=True)
class SelectDecided:
    """Selects the option that decided at this moment."""


@dataclass(frozen=True)
class Walk:
    """Selects an option around the selected one; the first root if there is none."""

    way: Way


@dataclass(frozen=True)
class OpenWeight:
    """Opens the reasons of a weight of the selected option; None closes them."""

    action: int | None


@dataclass(frozen=True)
class GoBack:
    """Returns to what was selected before, as in a browser."""


@dataclass(frozen=True)
class GoForward:
    """Undoes a return."""


@dataclass(frozen=True)
class ShowAhead:
    """Shows or hides where the agent expects to go; None changes which."""

    is_shown: bool | None


@dataclass(frozen=True)
class FindState:
    """Selects the option nearest to a typed state: a number for each feature, as people read it."""

    text: str


@dataclass(frozen=True)
class Fit:
    """Shows the whole forest."""


@dataclass(frozen=True)
class FocusPath:
    """Moves the camera to the path of the decision that is shown."""


@dataclass(frozen=True)
class FocusSelection:
    """Moves the camera to the selected option."""


@dataclass(frozen=True)
class ChooseArrangement:
    """Arranges the options otherwise; None: the next in turn."""

    arrangement: Arrangement | None


@dataclass(frozen=True)
class ChooseColoring:
    """Lets colours tell something else; None: the next in turn."""

    coloring: Coloring | None


@dataclass(frozen=True)
class ChooseAxis:
    """Puts a feature on an axis of the state space."""

    place: int  # 0 to 2.
    feature: int | None  # None: no such axis, which only the third may be.


@dataclass(frozen=True)
class LimitDepth:
    """Hides options further below their root; None hides none."""

    deepest: int | None


@dataclass(frozen=True)
class ChooseOver:
    """Draws training over something else."""

    over: Over


@dataclass(frozen=True)
class ChooseSmoothing:
    """Takes the running mean over so many episodes; 1 leaves it out."""

    episodes: int


@dataclass(frozen=True)
class LayBehind:
    """Draws a learner of the paper's comparison behind the returns, or no longer."""

    learner: str | None = None  # None: all of the task that is watched.
    is_laid: bool | None = None  # None: the other way round.


@dataclass(frozen=True)
class Download:
    """Sends a table as CSV."""

    table: Table


@dataclass(frozen=True)
class Fold:
    """Shows only the root of the selected option's schema, or all of it again."""


@dataclass(frozen=True)
class FoldAll:
    """Shows only the roots of all schemas, or everything again."""

    is_folded: bool


@dataclass(frozen=True)
class TidyUp:
    """Arranges the forest afresh; the only thing that moves options that are already there."""


@dataclass(frozen=True)
class Edit:
    """Fills in a field."""

    field: Field
    value: str | int


@dataclass(frozen=True)
class Press:
    """Presses a button of the run."""

    button: RunButton


@dataclass(frozen=True)
class ConfirmOverwrite:
    """Answers whether an existing file may be replaced."""

    is_yes: bool


@dataclass(frozen=True)
class SetTrainingSpeed:
    """Limits training to so many steps a second; None: no limit."""

    steps_per_s: float | None


@dataclass(frozen=True)
class ChooseDecideBy:
    """Switches the run between vote and path."""

    decide_by: DecideBy


Command = (
    Move
    | Seek
    | ReplayCommand
    | ShowLink
    | ChooseSource
    | ChooseEpisode
    | Pick
    | Select
    | SelectDecided
    | Walk
    | OpenWeight
    | GoBack
    | GoForward
    | ShowAhead
    | FindState
    | WhatIfCommand
    | CompareCommand
    | ExportCommand
    | LearnAgainCommand
    | WholeCommand
    | CallOff
    | Fit
    | FocusPath
    | FocusSelection
    | ChooseArrangement
    | ChooseColoring
    | ChooseAxis
    | LimitDepth
    | Fold
    | FoldAll
    | ChooseOver
    | ChooseSmoothing
    | LayBehind
    | Download
    | TidyUp
    | Edit
    | Press
    | ConfirmOverwrite
    | SetTrainingSpeed
    | ChooseDecideBy
    | AppearanceCommand
    | DialogCommand
    | NextStage
)
