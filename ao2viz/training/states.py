"""What a run can be doing, what people can ask of it, and which moves are legal."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

from ao2viz.core.config import Preset
from ao2viz.core.decision import DecideBy


class RunStatus(Enum):
    """What the run is doing."""

    IDLE = "idle"
    """Nothing to train yet."""
    PREPARING = "preparing"
    """Making the environment and compiling; the first time on a machine this takes a while."""
    RUNNING = "running"
    PAUSED = "paused"
    FINISHED = "finished"
    """All steps taken; what was learned has settled."""
    FAILED = "failed"
    """The environment or the agent raised; what was learned is kept and can be saved."""


@dataclass(frozen=True)
class Start:
    """Begins a new run, or with `resume_from` goes on with a saved agent."""

    env_id: str = "CartPole-v1"
    preset: Preset = Preset.ANTICIPATING
    seed: int = 0
    total_steps: int = 20_000
    overrides: Mapping[str, Any] = field(default_factory=dict)
    resume_from: Path | None = None  # An .ao2 file; then env_id, preset and seed are its own.


@dataclass(frozen=True)
class Resume:
    """Goes on after a pause."""


@dataclass(frozen=True)
class Pause:
    """Holds the run after the step under way."""


@dataclass(frozen=True)
class Step:
    """Takes a single step of the environment, then holds."""


@dataclass(frozen=True)
class RunEpisode:
    """Goes on to the end of the episode, then holds."""


@dataclass(frozen=True)
class TrainOn:
    """Takes more steps with the agent of a run that has ended."""

    more_steps: int


@dataclass(frozen=True)
class Stop:
    """Ends the run; the agent stays, to be looked at and saved."""


@dataclass(frozen=True)
class Save:
    """Writes the agent to a file."""

    path: Path
    is_copy: bool = False  # For somebody who waits for the file: nobody else needs to hear of it.


@dataclass(frozen=True)
class SetSpeed:
    """Limits training to so many steps a second; None: as fast as it goes."""

    steps_per_s: float | None


@dataclass(frozen=True)
class SetShare:
    """How much of the time is for learning; the rest may go into showing what was learned.

    From MIN_LEARNING to MAX_LEARNING. How fast steps are taken is all that it changes.
    """

    learning: float


MIN_LEARNING, MAX_LEARNING, USUAL_LEARNING = 0.5, 0.99, 0.95


@dataclass(frozen=True)
class SetDecideBy:
    """Switches between vote and path."""

    decide_by: DecideBy


@dataclass(frozen=True)
class ChangeSettings:
    """Changes settings of the run under way, all of them or, if one does not fit, none."""

    settings: Mapping[str, Any]


RunCommand = (
    Start
    | Resume
    | Pause
    | Step
    | RunEpisode
    | TrainOn
    | Stop
    | Save
    | SetSpeed
    | SetShare
    | SetDecideBy
    | ChangeSettings
)

IN_WORDS: Mapping[type[RunCommand], str] = {
    Start: "start a run",
    Resume: "resume",
    Pause: "pause",
    Step: "take a single step",
    RunEpisode: "run an episode",
    TrainOn: "train on",
    Stop: "stop",
    Save: "save",
    SetSpeed: "change the speed",
    SetShare: "change how much is shown",
    SetDecideBy: "change who decides",
    ChangeSettings: "change settings",
}

_HOLDS_AGENT = (RunStatus.RUNNING, RunStatus.PAUSED, RunStatus.FINISHED, RunStatus.FAILED)

# Where a legal command leads. What is not here is refused in words; buttons are enabled from it.
TRANSITIONS: Mapping[tuple[RunStatus, type[RunCommand]], RunStatus] = {
    **{
        (status, Start): RunStatus.PREPARING
        for status in (RunStatus.IDLE, RunStatus.FINISHED, RunStatus.FAILED, RunStatus.PAUSED)
    },
    (RunStatus.RUNNING, Pause): RunStatus.PAUSED,
    (RunStatus.PAUSED, Resume): RunStatus.RUNNING,
    (RunStatus.PAUSED, Step): RunStatus.PAUSED,
    (RunStatus.PAUSED, RunEpisode): RunStatus.RUNNING,
    (RunStatus.FAILED, Resume): RunStatus.RUNNING,
    (RunStatus.FINISHED, TrainOn): RunStatus.RUNNING,
    (RunStatus.RUNNING, Stop): RunStatus.FINISHED,
    (RunStatus.PAUSED, Stop): RunStatus.FINISHED,
    (RunStatus.PREPARING, Stop): RunStatus.IDLE,
    **{(status, Save): status for status in _HOLDS_AGENT},
    **{(status, SetSpeed): status for status in RunStatus},
    **{(status, SetShare): status for status in RunStatus},
    **{(status, SetDecideBy): status for status in _HOLDS_AGENT},
    **{(status, ChangeSettings): status for status in _HOLDS_AGENT},
}


def accepts(status: RunStatus, command: type[RunCommand]) -> bool:
    """Whether the command is legal now; a button is enabled exactly then."""
    return (status, command) in TRANSITIONS
