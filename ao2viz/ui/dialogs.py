"""What a command of the dialogs changes in one browser's session; pure, a part of `reduce`."""

from collections.abc import Mapping
from dataclasses import replace
from typing import assert_never

from ao2viz.core.config import Config
from ao2viz.training.states import ChangeSettings, RunStatus, SetShare, accepts
from ao2viz.ui.appearance import DismissHint, Remember
from ao2viz.ui.appearing import appear
from ao2viz.ui.dialog_commands import (
    ApplySettings,
    ChooseFolder,
    ChooseShare,
    CloseDialog,
    ConfirmUpload,
    DialogCommand,
    DownloadAgent,
    EditSetting,
    OpenDialog,
    ResetSettings,
    Uploaded,
)
from ao2viz.ui.downloads import Notify
from ao2viz.ui.session import Form, Session
from ao2viz.ui.settings import find_changes
from ao2viz.ui.shelf import ShelfEffect, answer_upload, send_agent, take_upload
from ao2viz.ui.world import World

Effect = Remember | ShelfEffect | ChangeSettings | SetShare


def attend(
    session: Session, command: DialogCommand, world: World
) -> tuple[Session, tuple[Effect, ...]]:
    """The session after a command, and what has to happen outside of it."""
    match command:
        case OpenDialog(dialog):
            is_open = session.dialog is dialog
            return replace(session, dialog=None if is_open else dialog), ()
        case CloseDialog():
            if session.dialog is None and not session.appearance.hint_is_gone:
                return appear(session, DismissHint())
            return replace(session, dialog=None), ()
        case EditSetting(name, text):
            return replace(session, form=_type(session.form, name, text)), ()
        case ResetSettings():
            form = replace(session.form, settings={}, resets=session.form.resets + 1)
            return replace(session, form=form), ()
        case ApplySettings():
            return session, (_apply(session, world),)
        case ChooseShare(learning):
            return session, (SetShare(learning),)
        case ChooseFolder(folder):
            return replace(session, form=replace(session.form, folder=folder)), ()
        case Uploaded():
            return take_upload(session, command, world)
        case ConfirmUpload():
            return answer_upload(session, command)
        case DownloadAgent():
            return session, (send_agent(command, world),)
        case _:
            assert_never(command)


def defaults_for(form: Form, world: World) -> Config | None:
    """What a new run of the form would begin with; None while nobody knows."""
    return world.defaults.get(form.env_id, {}).get(form.preset)


def _type(form: Form, name: str, text: str) -> Form:
    settings: Mapping[str, str] = {k: v for k, v in form.settings.items() if k != name}
    return replace(form, settings={**settings, name: text} if text.strip() else settings)


def _apply(session: Session, world: World) -> Effect:
    status = world.update.status
    config = world.update.config
    if not accepts(status, ChangeSettings) or status is RunStatus.FINISHED:
        config = None
    changes, problem = find_changes(session.form, config)
    return Notify("Not changed", problem, is_error=True) if problem else ChangeSettings(changes)
