"""The left dock: what is watched, its picture, the transport, the decision and its path."""

import time
from collections.abc import Callable

import viser
from viser._messages import HotkeyKey

from ao2viz.explain.ahead import Ahead
from ao2viz.recording.cycle import Stage
from ao2viz.ui import html, html_cycle, html_reasons
from ao2viz.ui.commands import (
    ChooseEpisode,
    ChooseSource,
    Move,
    Seek,
    SetPlaySpeed,
    Transport,
)
from ao2viz.ui.frames import BLANK, BLANK_JPEG
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_trigger
from ao2viz.ui.mirror import Mirror
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
        self._said: tuple[object, ...] = ()
        self._pictured: tuple[str, str] = ("", "")
        gui.add_html(html.no_tab())
        self._source = gui.add_dropdown("Watch", [LIVE])
        on_change(self._source, self._to_source, client_id, inbox)
        self._episode = gui.add_dropdown("Episode", [_NO_EPISODE])
        on_change(self._episode, self._to_episode, client_id, inbox)
        self._image = gui.add_image(BLANK, format="jpeg")
        gui.add_html(html.row(6))
        self._buttons: dict[Transport, viser.GuiButtonHandle] = {}
        self._keys: list[viser.CommandHandle] = []
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
        self._cycle = gui.add_html("")
        self._decision = gui.add_html("")
        self._path = gui.add_html("")
        self._ahead = gui.add_html("")
        self._told_ahead: Ahead | None = None

    def sync(
        self, view: View, frame: bytes | None, problem: str, ahead: Ahead | None = None
    ) -> None:
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
        self._slider.disabled = not transport.is_enabled
        self._sync_slider(transport.last, transport.position)
        pictured = view.forest_key[:2]
        if frame is not None:
            self._image._data = frame
        elif pictured != self._pictured:
            self._image._data = BLANK_JPEG
        self._pictured = pictured
        self._sync_words(view, problem)
        if ahead is not self._told_ahead:
            self._told_ahead = ahead
            if ahead is not None and view.spec is not None:
                self._ahead.content = html_reasons.ahead(ahead, view.spec)
            else:
                self._ahead.content = ""

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

    def _sync_words(self, view: View, problem: str) -> None:
        supposes = view.supposed is not None
        moment = (view.decision, supposes, view.notice, problem, view.forest_key)
        walk = None if supposes else view.walk
        shown = (None, None) if walk is None else (walk.cycle, walk.stage)
        said = (*moment, view.run.status, *shown)
        if all(a is b or a == b for a, b in zip(said, self._said, strict=False)) and self._said:
            return
        self._said = said
        self._cycle.content = ""
        if walk is not None and view.spec is not None and view.forest is not None:
            self._cycle.content = html_cycle.cycle_stages(walk, view.spec, view.forest)
            has_acted = walk.stage.number >= Stage.ACT.number
            has_found = walk.stage.number >= Stage.FIND.number
            told = html.decision(walk.cycle.decision, view.spec, view.forest)
            path = html.path(walk.cycle.decision, view.spec, view.forest)
            self._decision.content = told if has_acted else ""
            self._path.content = path if has_found else ""
            return
        if view.decision is not None and view.spec is not None:
            self._decision.content = html.decision(view.decision, view.spec, view.forest)
            self._path.content = html.path(view.decision, view.spec, view.forest)
        else:
            self._decision.content = html.notice(view.notice)
            self._path.content = ""
        if supposes:
            self._decision.content = html.supposing() + self._decision.content
        if problem:
            self._decision.content += html.notice(problem, is_error=True)

    def _to_source(self, label: str) -> ChooseSource | None:
        return self._shelf.get(label)

    def _to_episode(self, label: str) -> ChooseEpisode | None:
        return ChooseEpisode(self._episodes.index(label)) if label in self._episodes else None
