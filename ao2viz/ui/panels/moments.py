"""The left dock, below: moments worth a look, steps that meet a condition, and a link to here."""

from functools import partial

import viser
from viser._messages import HotkeyKey

from ao2viz.ui import html, html_replay
from ao2viz.ui.commands import Command, Seek
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_trigger
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.panels.links import Links
from ao2viz.ui.replay_commands import SeekStop, SetStop, ShowLink
from ao2viz.ui.view import View

_LISTED = 16
_STOPS: tuple[tuple[str, SeekStop, HotkeyKey], ...] = (
    ("← Stop", SeekStop(False), "7"),
    ("Stop →", SeekStop(True), "8"),
)


class MomentsPanel:
    """Where to go in the episode that is watched."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._listed: tuple[object, ...] = ()
        press = partial(on_click, client_id=client_id, inbox=inbox)
        trigger = partial(on_trigger, client_id=client_id, inbox=inbox)
        self._line = gui.add_html("")
        self._text = gui.add_text(
            "Stop when", "", hint="Playing holds at the first step that meets this; then Enter."
        )
        on_change(self._text, SetStop, client_id, inbox)
        self._text_shown = Mirror(self._text)
        self._told = gui.add_html("")
        gui.add_html(html.row(2))
        self._buttons = []
        for label, command, key in _STOPS:
            way = "next" if command.is_forward else "previous"
            words = f"The {way} step that meets the condition"
            button = gui.add_button(label, color="gray", hint=f"{words}.")
            press(button, command)
            self._buttons.append(button)
            trigger(gui.add_command(f"Replay: {words.lower()}", hotkey=key), command)
        self._moments = Links(gui, "Moments worth a look", client_id, inbox, _LISTED)
        gui.add_html('<div class="ao"><h4>Link to this moment</h4></div>')
        self._links = gui.add_html("")
        trigger(gui.add_command("Replay: link to this moment"), ShowLink())

    def sync(self, view: View) -> None:
        """Shows what there is to go to."""
        replay = view.replay
        self._line.content = html_replay.line(view)
        if not replay.stop_problem:  # What was typed stays as it is until it is right.
            self._text_shown.show(replay.stop_text)
        self._told.content = html_replay.stops(view)
        for button in self._buttons:
            button.disabled = not (replay.stop_text and view.transport.is_enabled)
        if replay.moments != self._listed:
            self._listed = replay.moments
            links: list[tuple[str, Command]] = [
                (f"{moment.step:,} · {moment.words}", Seek(moment.step))
                for moment in replay.moments
            ]
            self._moments.sync(links)
        self._links.content = html_replay.links(view)
