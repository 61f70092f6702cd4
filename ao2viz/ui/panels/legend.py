"""The small panel over the canvas: what its colours and lines mean, and the view buttons."""

import viser
from viser._messages import HotkeyKey

from ao2viz.ui import html
from ao2viz.ui.commands import Command, Fit, FocusPath, TidyUp
from ao2viz.ui.inbox import Inbox, on_click, on_trigger
from ao2viz.ui.view import View

_BUTTONS: tuple[tuple[str, str, viser.IconName, Command, HotkeyKey], ...] = (
    ("Fit", "show the whole forest", viser.Icon.ARROWS_MAXIMIZE, Fit(), "F"),
    ("Path", "show the path", viser.Icon.FOCUS, FocusPath(), "V"),
    ("Tidy", "arrange the forest afresh", viser.Icon.LAYOUT, TidyUp(), "Y"),
)


class LegendPanel:
    """The legend, which explains the canvas in words."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._shown: tuple[object, object] = (None, None)
        gui.add_html(html.no_tab())
        self._text = gui.add_html(html.legend(None, None))
        gui.add_html(html.row(3))
        for label, words, icon, command, key in _BUTTONS:
            button = gui.add_button(label, icon=icon, color="gray")
            on_click(button, command, client_id, inbox)
            trigger = gui.add_command(f"Canvas: {words}", hotkey=key, icon=icon)
            on_trigger(trigger, command, client_id, inbox)

    def sync(self, view: View) -> None:
        """Shows the legend of the forest on the canvas."""
        shown = (view.spec, view.forest)
        if shown[0] is self._shown[0] and shown[1] is self._shown[1]:
            return
        self._shown = shown
        self._text.content = html.legend(view.spec, view.forest)
