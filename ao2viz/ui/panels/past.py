"""The left dock, below: the forest at any moment of training."""

from functools import partial

import viser
from viser._messages import HotkeyKey

from ao2viz.core.decision import Decision
from ao2viz.ui import html, html_past, html_replay
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_trigger
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.replay_commands import LookAround, LookBack
from ao2viz.ui.view import View

_BUTTONS: tuple[tuple[str, str, LookAround | LookBack, HotkeyKey], ...] = (
    ("Earlier", "a fiftieth of the agent's life earlier", LookAround(False), "A"),
    ("Later", "a fiftieth of the agent's life later", LookAround(True), "D"),
    ("Now", "back to now", LookBack(None), "E"),
)


class PastPanel:
    """A slider over training time."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        press = partial(on_click, client_id=client_id, inbox=inbox)
        self._line = gui.add_html("")
        self._slider = gui.add_slider("After step", 0, 1, 1, 1)
        on_change(self._slider, LookBack, client_id, inbox)
        self._slider_shown = Mirror(self._slider)
        gui.add_html(html.row(3))
        self._buttons: list[viser.GuiButtonHandle] = []
        self._keys: list[viser.CommandHandle] = []
        for label, words, command, key in _BUTTONS:
            button = gui.add_button(label, color="gray", hint=words.capitalize())
            press(button, command)
            self._buttons.append(button)
            trigger = gui.add_command(f"Past: {words}", hotkey=key, modifier="shift")
            on_trigger(trigger, command, client_id, inbox)
            self._keys.append(trigger)
        self._facts = gui.add_html("")

    def sync(self, view: View, then: Decision | None) -> None:
        """Shows the moment; `then` is what the agent would have decided, once that is known."""
        self._line.content = html_replay.line(view)
        step = view.n_lived if view.back is None else view.back.moment.step
        self._slider_shown.show_within(max(1, view.n_lived), step)
        self._slider.disabled = view.n_lived == 0
        now = self._buttons[-1]
        now.color = "gray" if view.back is None else "blue"
        for button, key in zip(self._buttons, self._keys, strict=True):
            button.disabled = key.disabled = view.n_lived == 0
        self._facts.content = html_past.past_facts(view, then)
