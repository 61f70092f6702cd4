"""What opens in the middle of the page. Viser's dialogs close only when the server says so."""

from typing import Protocol, cast

import viser
from viser._gui_handles import GuiModalHandle
from viser._messages import HotkeyKey

from ao2viz.ui import html
from ao2viz.ui.dialog_commands import (
    CloseDialog,
    Dialog,
    DownloadAgent,
    OpenDialog,
)
from ao2viz.ui.html_help import help_page
from ao2viz.ui.inbox import Inbox, on_click, on_trigger
from ao2viz.ui.panels.library import LibraryDialog
from ao2viz.ui.panels.page import AppearanceFields
from ao2viz.ui.panels.settings import SettingsDialog
from ao2viz.ui.view import View

# Viser's list of keys leaves this one out; the page takes any sign that a keyboard can type.
_QUESTION_MARK = cast(HotkeyKey, "?")

_KEYS: tuple[tuple[str, HotkeyKey, Dialog], ...] = (  # Each with Shift.
    ("Page: help, all keys and commands", _QUESTION_MARK, Dialog.HELP),
    ("Training: settings", "S", Dialog.SETTINGS),
    ("Page: library, agents to open, upload and download", "L", Dialog.LIBRARY),
)


class Content(Protocol):
    """What fills a dialog."""

    def sync(self, view: View) -> None:
        """Shows the view."""
        ...


class DialogsPanel:
    """Opens and closes the dialogs of one browser."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._gui, self._client_id, self._inbox = gui, client_id, inbox
        self._shown: Dialog | None = None
        self._modal: GuiModalHandle | None = None
        self._content: Content | None = None
        for label, key, dialog in _KEYS:
            command = gui.add_command(label, hotkey=key, modifier="shift")
            on_trigger(command, OpenDialog(dialog), client_id, inbox)
        close = gui.add_command("Page: close what is open", hotkey="escape")
        on_trigger(close, CloseDialog(), client_id, inbox)
        download = gui.add_command("Download: the agent of the run")
        on_trigger(download, DownloadAgent(None), client_id, inbox)

    def sync(self, view: View) -> None:
        """Shows the dialog that is to be open, if there is one."""
        if view.dialog is not self._shown:
            if self._modal is not None:
                self._modal.close()
            self._shown, self._modal, self._content = view.dialog, None, None
            if view.dialog is not None:
                modal = self._modal = self._gui.add_modal(view.dialog.value)
                with modal:
                    self._content = self._fill(view.dialog, view)
        if self._content is not None:
            self._content.sync(view)

    def _fill(self, dialog: Dialog, view: View) -> Content:
        put = (self._gui, self._client_id, self._inbox)
        match dialog:
            case Dialog.SETTINGS:
                content = SettingsDialog(*put, view)
                add_close(*put)
                return content
            case Dialog.LIBRARY:
                add_close(*put)  # First, for a dialog opens with its first control in focus.
                return LibraryDialog(*put, view)
            case Dialog.HELP:
                return HelpDialog(*put, view)


def add_close(gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
    """The button that every dialog has."""
    close = gui.add_button("Close", color="gray", icon=viser.Icon.X)
    on_click(close, CloseDialog(), client_id, inbox)


class HelpDialog:
    """How the page looks, all keys and commands."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox, view: View) -> None:
        gui.add_html(html.dialog())
        add_close(gui, client_id, inbox)  # First, as in the library.
        self._appearance = AppearanceFields(gui, client_id, inbox)
        gui.add_html(help_page(inbox.keys_of(client_id)))
        self.sync(view)

    def sync(self, view: View) -> None:
        """Shows what was chosen."""
        self._appearance.sync(view)
