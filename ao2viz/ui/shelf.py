"""What a person does with agent files: where they go, what they may be called; pure."""

import re
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath, PureWindowsPath

from ao2viz.store.files import SUFFIX
from ao2viz.training.states import Save, accepts
from ao2viz.ui.dialog_commands import ConfirmUpload, DownloadAgent, Uploaded
from ao2viz.ui.downloads import Notify
from ao2viz.ui.session import Session, Upload
from ao2viz.ui.world import World

MAX_UPLOAD_BYTES = 64 * 2**20
"""Far more than any agent that can be watched at ease; the largest bundled one has 2 MiB."""

_NAME = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._ -]{0,78}[A-Za-z0-9])?")
NAME_RULE = (
    "A file name is up to 80 letters, digits, spaces, dots, dashes and underscores; "
    "it begins and ends with a letter or a digit."
)


@dataclass(frozen=True)
class KeepUpload:
    """Asks to check what was uploaded, and to keep it there if it is an agent."""

    upload: Upload


@dataclass(frozen=True)
class SendAgent:
    """Asks to hand an agent's file to the browser; None: the agent of the run."""

    path: Path | None


ShelfEffect = KeepUpload | SendAgent | Notify


def folder_for(session: Session, world: World) -> Path:
    """Where this browser's agents go: only ever one of the folders that are allowed."""
    chosen = session.form.folder
    return chosen if chosen is not None and chosen in world.folders else world.folder


def path_for(name: str, session: Session, world: World) -> Path | None:
    """The file that a typed name means; None if nothing may be called that."""
    stem = name.strip().removesuffix(SUFFIX)
    if not _NAME.fullmatch(stem):
        return None
    return folder_for(session, world) / f"{stem}{SUFFIX}"


def take_upload(
    session: Session, command: Uploaded, world: World
) -> tuple[Session, tuple[ShelfEffect, ...]]:
    """Finds a place for an uploaded file, and asks if another one has it."""
    # A browser may claim any path as the name, of whatever system.
    name = PurePosixPath(PureWindowsPath(command.name).name).name
    path = path_for(name, session, world)
    problem = ""
    if not name.endswith(SUFFIX):
        problem = f"Expected an agent's file, which ends in {SUFFIX}."
    elif path is None:
        problem = NAME_RULE
    elif len(command.content) > MAX_UPLOAD_BYTES:
        problem = f"Expected at most {MAX_UPLOAD_BYTES // 2**20} MiB."
    if problem or path is None:
        return session, (Notify("Not uploaded", problem, is_error=True),)
    upload = Upload(path, command.content)
    if path.exists():
        return replace(session, upload=upload), ()
    return replace(session, upload=None), (KeepUpload(upload),)


def answer_upload(
    session: Session, command: ConfirmUpload
) -> tuple[Session, tuple[ShelfEffect, ...]]:
    """Replaces the old file by the uploaded one, or forgets that."""
    upload, session = session.upload, replace(session, upload=None)
    return session, ((KeepUpload(upload),) if command.is_yes and upload is not None else ())


def send_agent(command: DownloadAgent, world: World) -> ShelfEffect:
    """Only what stands on the shelf leaves it, and the agent of the run."""
    if command.path is None:
        if not accepts(world.update.status, Save):
            return Notify("Not downloaded", "There is no run whose agent could be downloaded.")
        return SendAgent(None)
    if command.path not in {item.path for item in world.shelf}:
        return Notify("Not downloaded", "This file is not on the shelf any more.", is_error=True)
    return SendAgent(command.path)
