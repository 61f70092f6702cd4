"""What a person can ask of a replay beside moving through it; part of `commands.Command`."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SetPlaySpeed:
    """How fast a recorded episode plays: a factor of the usual pace."""

    factor: float


@dataclass(frozen=True)
class ShowMoment:
    """Shows a step of a recorded episode."""

    episode: int
    step: int


@dataclass(frozen=True)
class SetLoop:
    """Lets an episode begin anew at its end, or hold there; None changes which."""

    is_on: bool | None


@dataclass(frozen=True)
class SeekMoment:
    """Shows the next moment worth a look, or the one before."""

    is_forward: bool


@dataclass(frozen=True)
class SetStop:
    """Lets playing hold at the first step that meets a condition; no text: at none."""

    text: str


@dataclass(frozen=True)
class SeekStop:
    """Shows the next step that meets the condition, or the one before."""

    is_forward: bool


@dataclass(frozen=True)
class TakeOver:
    """Chooses the action of the step that is shown; the agent goes on from there, in a branch."""

    action: int


@dataclass(frozen=True)
class LimitBranch:
    """Ends coming branches after so many steps of the agent; 0: with the episode."""

    steps: int


@dataclass(frozen=True)
class CancelBranch:
    """Calls off the branch that is being played."""


@dataclass(frozen=True)
class Rejoin:
    """Leaves a branch: back to the main line, at the step of departure."""


@dataclass(frozen=True)
class ShowLink:
    """Shows what opens this moment again."""


@dataclass(frozen=True)
class LookBack:
    """Shows the forest as it was after a step of training; None: as it is now."""

    step: int | None


@dataclass(frozen=True)
class LookAround:
    """Goes a fiftieth of the agent's life back from the moment that is shown, or forward."""

    is_forward: bool


ReplayCommand = (
    SetPlaySpeed
    | ShowMoment
    | SetLoop
    | SeekMoment
    | SetStop
    | SeekStop
    | TakeOver
    | LimitBranch
    | CancelBranch
    | Rejoin
    | LookBack
    | LookAround
)
