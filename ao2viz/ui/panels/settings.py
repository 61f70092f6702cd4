"""The dialog of settings: those of the next run, and of the run under way where it lets them."""

from functools import partial
from typing import Any

import viser

from ao2viz.ui import html
from ao2viz.ui.dialog_commands import ApplySettings, CloseDialog, EditSetting, ResetSettings
from ao2viz.ui.html_settings import caption, introduction
from ao2viz.ui.inbox import Inbox, on_change, on_click
from ao2viz.ui.settings import SettingRow, told
from ao2viz.ui.view import View


class SettingsDialog:
    """A field for every setting, and beside it what it does."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox, view: View) -> None:
        self._rows: dict[str, SettingRow] = {}
        self._resets = view.form.resets
        gui.add_html(html.dialog())
        self._words = gui.add_html("")
        gui.add_html(html.row(3))
        close = gui.add_button("Close", color="gray", icon=viser.Icon.X)
        on_click(close, CloseDialog(), client_id, inbox)
        reset = gui.add_button(
            "Defaults", color="gray", icon=viser.Icon.RESTORE, hint="Takes all of them back."
        )
        on_click(reset, ResetSettings(), client_id, inbox)
        self._apply = gui.add_button(
            "Change the run",
            color="gray",
            icon=viser.Icon.CHECK,
            hint="Gives what is typed to the run under way, where that can change any more.",
        )
        on_click(self._apply, ApplySettings(), client_id, inbox)
        self._fields: dict[str, Any] = {}
        self._captions: dict[str, viser.GuiHtmlHandle] = {}
        group = None
        for row in view.settings:
            setting = row.setting
            if setting.group is not group:
                group = setting.group
                gui.add_html(f'<div class="ao"><h4>{html.esc(group.value)}</h4></div>')
            gui.add_html(html.row(2))
            words = setting.choices
            if isinstance(setting.default, bool):
                words = (told(True), told(False))
            if words:
                text = row.text if row.text in words else told(row.default)
                field = gui.add_dropdown(setting.name, words, initial_value=text)
            else:
                field = gui.add_text(setting.name, row.text)
            on_change(field, partial(EditSetting, setting.name), client_id, inbox)
            self._fields[setting.name] = field
            self._captions[setting.name] = gui.add_html("")

    def sync(self, view: View) -> None:
        """Says of every setting what is to be said; never types where a person does."""
        self._words.content = introduction(view.form, view.run)
        if view.form.resets != self._resets:
            self._resets = view.form.resets
            for row in view.settings:
                self._fields[row.setting.name].value = told(row.default)
        for row in view.settings:
            name = row.setting.name
            known = self._rows.get(name)
            if row == known or name not in self._captions:
                continue
            if (
                known is not None
                and row.default != known.default
                and name not in view.form.settings
            ):
                self._fields[name].value = told(row.default)  # The environment's own, found out.
            self._rows[name] = row
            self._captions[name].content = caption(row)
        self._apply.disabled = view.run.config is None
