"""The left dock, above: what is watched, its picture and the transport."""

import time
from collections.abc import Callable

import viser
from viser._messages import HotkeyKey

from ao2viz.ui import html
from ao2viz.ui.commands import ChooseEpisode, ChooseSource, Move, Seek, Transport
from ao2viz.ui.frames import BLANK, BLANK_JPEGS
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_trigger
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.replay_commands import SeekMoment, SetLoop, SetPlaySpeed
from ao2viz.ui.view import View

LIVE: str = "Training, live"
_SPEEDS = {"⅛×": 1 / 8, "¼×": 1 / 4, "½×": 1 / 2, "1×": 1.0, "2×": 2.0, "4×": 4.0, "8×": 8.0}
_BUTTONS: tuple[tuple[Transport, str, viser.IconName, HotkeyKey], ...] = (
    (Transport.FIRST, "First step", viser.Icon.PLAYER_SKIP_BACK, "Q"),
    (Transport.BACK, "Step back", viser.Icon.PLAYER_TRACK_PREV, "A"),
    (Transport.PLAY, "Play", viser.Icon.PLAYER_PLAY, "P"),
    (Transport.FORWARD, "Step forward", viser.Icon.PLAYER_TRACK_NEXT, "D"),
    (Transport.LAST, "Last step", viser.Icon.PLAYER_SKIP_FORWARD, "E"),
)
_MOMENTS: tuple[tuple[str, SeekMoment, HotkeyKey], ...] = (
    ("← Moment", SeekMoment(False), "2"),
    ("Moment →", SeekMoment(True), "3"),
)
_NO_EPISODE: str = "none recorded"
_SETTLED_S = 0.5  # After so long without a change the slider is sent once more.


class WatchPanel:
    """One browser's place in what happened."""

    def __init__(
        self,
        gui: viser.GuiApi,
        client_id: int,
        inbox: Inbox,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock = clock
        self._moved: tuple[tuple[int, int], float | None] = ((0, 0), None)  # Place, and since when.
        self._shelf: dict[str, ChooseSource] = {}
        self._episodes: tuple[str, ...] = ()
        self._pictured: tuple[object, ...] = ()
        gui.add_html(html.no_tab())
        self._source = gui.add_dropdown("Watch", [LIVE])
        on_change(self._source, self._to_source, client_id, inbox)
        self._episode = gui.add_dropdown("Episode", [_NO_EPISODE])
        on_change(self._episode, self._to_episode, client_id, inbox)
        self._image = gui.add_image(BLANK, format="jpeg")
        gui.add_html(html.row(6))
        self._buttons: dict[Transport, viser.GuiButtonHandle] = {}
        self._keys: list[viser.CommandHandle] = []
        self._steering: list[viser.GuiButtonHandle] = []
        for to, label, icon, key in _BUTTONS:
            self._buttons[to] = button = gui.add_button(label, icon=icon, color="gray")
            on_click(button, Move(to), client_id, inbox)
            command = gui.add_command(f"Replay: {to.value}", hotkey=key, icon=icon)
            on_trigger(command, Move(to), client_id, inbox)
            self._keys.append(command)
        self._speed = gui.add_dropdown("Speed", tuple(_SPEEDS), initial_value="1×")
        on_change(self._speed, lambda s: SetPlaySpeed(_SPEEDS[s]), client_id, inbox)
        self._slider = gui.add_slider("Step", 0, 1, 1, 0)
        on_change(self._slider, Seek, client_id, inbox)
        self._source_shown = Mirror(self._source)
        self._episode_shown = Mirror(self._episode)
        self._slider_shown = Mirror(self._slider)
        gui.add_html(html.row(3))
        for label, command, key in _MOMENTS:
            hint = f"The moment worth a look {'after' if command.is_forward else 'before'} this one"
            button = gui.add_button(
                label, color="gray", hint=f"{hint}; the Moments tab lists them."
            )
            on_click(button, command, client_id, inbox)
            trigger = gui.add_command(f"Replay: {hint[0].lower()}{hint[1:]}", hotkey=key)
            on_trigger(trigger, command, client_id, inbox)
            self._steering.append(button)
            self._keys.append(trigger)
        self._loop = gui.add_button(
            "Loop", icon=viser.Icon.REPEAT, color="gray", hint="Begins anew at the end."
        )
        on_click(self._loop, SetLoop(None), client_id, inbox)
        trigger = gui.add_command("Replay: loop, or hold at the end", hotkey="P", modifier="shift")
        on_trigger(trigger, SetLoop(None), client_id, inbox)

    def sync(self, view: View, frame: bytes | None) -> None:
        """Shows the view; `frame` is the JPEG of this moment, None keeps the last one."""
        self._sync_choices(view)
        transport = view.transport
        for to, button in self._buttons.items():
            button.disabled = not transport.is_enabled
            if to is Transport.PLAY:
                is_playing = transport.is_playing and transport.is_enabled
                icon = "PLAYER_PAUSE" if is_playing else "PLAYER_PLAY"
                if button.icon != getattr(viser.Icon, icon):
                    button.icon = getattr(viser.Icon, icon)
                    button.label = "Hold" if is_playing else "Play"
        for key in self._keys:
            key.disabled = not transport.is_enabled
        for button in self._steering:
            button.disabled = not transport.is_enabled
        color = "blue" if view.replay.loops else "gray"
        if self._loop.color != color:
            self._loop.color = color
        self._slider.disabled = not transport.is_enabled
        self._sync_slider(transport.last, transport.position)
        theme = view.appearance.shown_theme
        pictured = (*view.forest_key[:2], theme)
        if frame is not None:
            self._image._data = frame
        elif pictured != self._pictured:
            self._image._data = BLANK_JPEGS[theme]
        self._pictured = pictured

    def _sync_slider(self, last: int, position: int) -> None:
        self._slider_shown.show_within(max(1, last), position)
        place, since = self._moved
        if place != (last, position):
            self._moved = (last, position), self._clock()
        elif since is not None and self._clock() - since > _SETTLED_S:
            self._moved = place, None
            self._slider_shown.insist()

    def _sync_choices(self, view: View) -> None:
        labels = {item.label: ChooseSource(item.path) for item in view.shelf}
        if view.has_run or not labels:
            labels[LIVE] = ChooseSource(None)
        if view.source is not None and ChooseSource(view.source) not in labels.values():
            labels[f"{view.source.stem} (file is gone)"] = ChooseSource(view.source)
        shown = next((k for k, c in labels.items() if c.path == view.source), LIVE)
        if labels != self._shelf:
            self._shelf = labels
        self._source_shown.show_among(tuple(labels), shown)
        episodes = view.episodes or (_NO_EPISODE,)
        self._episodes = episodes
        self._episode_shown.show_among(
            episodes, episodes[min(view.episode_index, len(episodes) - 1)]
        )
        self._episode.visible = view.source is not None
        self._episode.disabled = not view.episodes

    def _to_source(self, label: str) -> ChooseSource | None:
        return self._shelf.get(label)

    def _to_episode(self, label: str) -> ChooseEpisode | None:
        return ChooseEpisode(self._episodes.index(label)) if label in self._episodes else None
