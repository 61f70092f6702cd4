"""The small panel over the canvas: what its colours and lines mean, and the view buttons."""

import viser
from viser._messages import HotkeyKey

from ao2viz.training.states import RunStatus
from ao2viz.ui import html, html_past
from ao2viz.ui.close_up import CloseUp
from ao2viz.ui.commands import Command, Fit, FocusPath, FocusSelection, TidyUp
from ao2viz.ui.html_forest import legend, legend_size
from ao2viz.ui.inbox import Inbox, on_click, on_trigger
from ao2viz.ui.look import Look
from ao2viz.ui.picture import Picture
from ao2viz.ui.view import View

_WIDTH_PX = 230
_GAP_PX = 10
_BUTTONS: tuple[tuple[str, str, Command, HotkeyKey], ...] = (
    ("Fit", "show the whole forest", Fit(), "F"),
    ("Path", "show the path", FocusPath(), "V"),
    ("Option", "show the selected option", FocusSelection(), "G"),
    ("Tidy", "arrange the forest afresh", TidyUp(), "Y"),
)


class LegendPanel:
    """The legend, which each browser can move and minimise as it likes."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._shown: tuple[object, ...] = ()
        self.size = (0.0, 0.0)  # Pixels of the canvas that it covers, lower left.
        panel = gui.add_panel()
        panel.float(x=_GAP_PX, y=-_GAP_PX, width=_WIDTH_PX)
        with panel.add_tab("Legend", viser.Icon.INFO_CIRCLE):
            gui.add_html(html.no_tab())
            self._text = gui.add_html(legend(None, None, Look(), None))
            gui.add_html(html.row(4))
            for label, words, command, key in _BUTTONS:
                button = gui.add_button(label, color="gray", hint=words.capitalize())
                on_click(button, command, client_id, inbox)
                trigger = gui.add_command(f"Canvas: {words}", hotkey=key)
                on_trigger(trigger, command, client_id, inbox)

    def sync(self, view: View, picture: Picture | None, close_up: CloseUp | None = None) -> None:
        """Shows the legend of what is on the canvas."""
        forest = view.forest if view.back is None else view.back.moment.view
        left_out = close_up.n_left_out if close_up is not None else 0
        is_coming = not view.is_trouble and (view.source is not None or _is_under_way(view))
        shown = (view.spec, forest, view.look, picture, left_out, is_coming)
        if self._shown and all(a is b or a == b for a, b in zip(shown, self._shown, strict=True)):
            return
        self._shown = shown
        words = html_past.canvas_line(view)
        self._text.content = words + legend(
            view.spec,
            forest,
            view.look,
            picture,
            html_past.say_grey(view.back),
            left_out,
            is_coming,
        )
        size = legend_size(view.spec, forest, view.look, picture)
        self.size = size[0] + _GAP_PX, size[1] + _GAP_PX


def _is_under_way(view: View) -> bool:
    return view.run.status in (RunStatus.PREPARING, RunStatus.RUNNING)
