"""What a person can ask in the dialogs and of the page as a whole; a part of `commands.Command`."""

from dataclasses import dataclass
from enum import Enum
from pathlib import Path


class Dialog(Enum):
    """What opens in the middle of the page; the values are its titles."""

    SETTINGS = "Settings"
    LIBRARY = "Library"
    HELP = "Help"


@dataclass(frozen=True)
class OpenDialog:
    """Opens a dialog; the one that is open already closes."""

    dialog: Dialog


@dataclass(frozen=True)
class CloseDialog:
    """Closes whatever dialog is open."""


@dataclass(frozen=True)
class EditSetting:
    """Types a setting of the next run; nothing takes it back to its default."""

    name: str
    text: str


@dataclass(frozen=True)
class ResetSettings:
    """Takes all settings of the next run back to their defaults."""


@dataclass(frozen=True)
class ApplySettings:
    """Gives the run under way the settings that can change in the middle of it."""


@dataclass(frozen=True)
class ChooseShare:
    """How much of the time is for learning, the rest for showing it."""

    learning: float


@dataclass(frozen=True)
class ChooseFolder:
    """Where agents are saved and uploaded to, of the folders that the command line allows."""

    folder: Path


@dataclass(frozen=True)
class Uploaded:
    """A file that a browser sent; nothing about it is believed yet."""

    name: str
    content: bytes


@dataclass(frozen=True)
class ConfirmUpload:
    """Answers whether an uploaded file may replace one that is there."""

    is_yes: bool


@dataclass(frozen=True)
class DownloadAgent:
    """Sends an agent's file to the browser; None: the agent of the run, as it is now."""

    path: Path | None


@dataclass(frozen=True)
class NextStage:
    """Walks on through the stages of a single step of the run; after the last, takes a step."""


DialogCommand = (
    OpenDialog
    | CloseDialog
    | EditSetting
    | ResetSettings
    | ApplySettings
    | ChooseShare
    | ChooseFolder
    | Uploaded
    | ConfirmUpload
    | DownloadAgent
)
