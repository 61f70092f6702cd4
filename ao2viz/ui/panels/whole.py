"""The right dock, below: the agent as a whole, and from each fact a click to its place."""

from functools import partial

import viser

from ao2viz.explain.whole import Carriers, Coverage, Highlight, Roles, moment_of
from ao2viz.explain.words import number, percent
from ao2viz.ui import html, html_past, html_whole
from ao2viz.ui.commands import Command, Select
from ao2viz.ui.inbox import Inbox, on_change, on_press
from ao2viz.ui.jobs import Jobs, JobState
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.panels.links import Links
from ao2viz.ui.questions import (
    CallOff,
    ChooseMuted,
    ChooseMutedEpisodes,
    LookAtWhole,
    Mute,
    Task,
)
from ao2viz.ui.replay_commands import ShowMoment
from ao2viz.ui.stage import AGENT, show_tab
from ao2viz.ui.view import View
from ao2viz.ui.whole import MOST_EPISODES, MOST_MUTED, Kept, Playing, Portrait

_LOOK: str = "Look at the whole agent"
_AGAIN: str = "Look again"
_END: str = "End"
_MUTE: str = "Mute these"
_MOST_SHOWN = 200  # Of each list; their number is told all the same.
_OF_NOW = "Below stands the agent as it is now, not as it was at the moment on the canvas."


class WholePanel:
    """The whole agent that one browser watches."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._gui = gui
        self._kept = Kept()
        self._looks = 0
        self._portrait: Portrait | None = None
        self._selected = -1
        self._roles: Roles | None = None
        self._highlights: tuple[Highlight, ...] | None = None
        self._coverage: Coverage | None = None
        self._told: Carriers | None = None
        self._muted = 0
        self._farthest_at: tuple[int, int] | None = None
        press = partial(on_press, client_id=client_id, inbox=inbox)
        put = partial(on_change, client_id=client_id, inbox=inbox)
        make = partial(Links, gui, client_id=client_id, inbox=inbox)
        self._line = gui.add_html("")
        self._heading = gui.add_html("")
        self._look = gui.add_button(
            _LOOK, color="blue", hint="Asks at recorded states, beside the page; it can be ended."
        )
        press(self._look, self._look_or_end)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._progress = gui.add_html("")
        self._attention = gui.add_html("")
        self._moments = make("Moments that show it best", shown=5)
        self._covered = gui.add_html("")
        self._farthest = gui.add_button("–", color="gray", visible=False)
        press(self._farthest, self._to_farthest)
        self._told_roles = gui.add_html("")
        self._deciding = make("Decide, the most often first", shown=5)
        self._supporting = make("Only support, the most visited first", shown=0, more="Supports")
        self._redundant = make("Could be left out, one at a time", shown=0, more="To spare")
        self._faithful = gui.add_html("")
        self._carriers = gui.add_html(html_whole.carriers_heading(), visible=False)
        self._row = gui.add_html(html.row(2), visible=False)
        self._options = gui.add_number("Options", 5, min=1, max=MOST_MUTED, step=1, visible=False)
        put(self._options, ChooseMuted)
        self._episodes = gui.add_number(
            "Episodes", 10, min=1, max=MOST_EPISODES, step=1, visible=False
        )
        put(self._episodes, ChooseMutedEpisodes)
        self._options_shown, self._episodes_shown = Mirror(self._options), Mirror(self._episodes)
        self._buttons_row = gui.add_html(html.row(2), visible=False)
        self._mute = gui.add_button(
            _MUTE, color="gray", visible=False, hint="Those that decide most often, one at a time."
        )
        press(self._mute, self._mute_or_end)
        self._mute_selected = gui.add_button("Mute the selected", color="gray", visible=False)
        press(self._mute_selected, self._to_mute_selected)
        self._mute_bar = gui.add_progress_bar(0.0, visible=False)
        self._told_carriers = gui.add_html("")
        self._losses = make("Losses, the greatest first", shown=5)
        key = gui.add_command("Agent: look at the whole agent", hotkey="W", modifier="shift")
        press(key, self._show)
        mute = gui.add_command("Agent: which options carry the return, or end that")
        press(mute, self._mute_or_end)
        press(gui.add_command("Agent: end counting"), lambda: CallOff(Task.WHOLE))

    def sync(self, view: View, jobs: Jobs) -> None:
        """Shows what can be asked, how far it is, and what is known."""
        whole = view.whole
        if whole.looks != self._looks:
            self._looks = whole.looks
            show_tab(self._gui, AGENT)
        job = self._kept.look(jobs, Task.WHOLE, whole.subject)
        portrait = self._portrait = html_whole.portrait_of(job)
        self._line.content = html_past.of_now(view, _OF_NOW)
        self._heading.content = html_whole.heading(whole)
        self._sync_look(view, job)
        self._attention.content = (
            html_whole.attention(portrait, view.spec) if view.spec is not None else ""
        )
        self._sync_moments(view, portrait)
        self._sync_roles(view, portrait)
        self._faithful.content = html_whole.faithfulness(portrait)
        self._sync_carriers(view, self._kept.look(jobs, Task.MUTE, whole.subject))

    def _sync_look(self, view: View, job: JobState | None) -> None:
        is_busy = job is not None and not job.is_done
        is_known = self._portrait is not None and self._portrait.is_complete
        label = _END if is_busy else _LOOK if job is None else _AGAIN
        if self._look.label != label:
            self._look.label = label
        self._look.visible = not is_known
        self._look.disabled = bool(view.whole.problem)
        self._bar.visible = is_busy
        self._bar.value = 100.0 * html_whole.share_of(job)
        self._progress.content = html_whole.progress(job)

    def _sync_moments(self, view: View, portrait: Portrait | None) -> None:
        highlights = portrait.highlights if portrait is not None else None
        if highlights is not self._highlights:
            self._highlights = highlights
            self._moments.sync(
                [
                    (html_whole.highlight_words(one), ShowMoment(one.episode, one.step))
                    for one in highlights or ()
                ]
            )
        self._covered.content = html_whole.coverage(portrait)
        coverage = portrait.coverage if portrait is not None else None
        if coverage is not self._coverage:
            self._coverage = coverage
            place = None if coverage is None else moment_of(coverage.farthest, view.recorded)
            self._farthest_at = place
            self._farthest.visible = place is not None
            if place is not None and coverage is not None:
                away = number(float(coverage.distances.max(initial=0.0)))
                words = f"Farthest: episode {place[0] + 1}, step {place[1]}, {away} away"
                self._farthest.label = words

    def _sync_roles(self, view: View, portrait: Portrait | None) -> None:
        roles = portrait.roles if portrait is not None else None
        self._told_roles.content = html_whole.roles(portrait)
        if roles is self._roles:
            return
        self._roles = roles
        if roles is None or view.forest is None:
            for links in (self._deciding, self._supporting, self._redundant):
                links.sync([])
            return
        often = zip(roles.deciding.tolist(), roles.decided.tolist(), strict=True)
        self._deciding.sync(
            [
                (f"Option {option}: {percent(times / roles.states)} of the states", Select(option))
                for option, times in list(often)[:_MOST_SHOWN]
            ],
            len(roles.deciding),
        )
        visits = view.forest.visits.sum(axis=1)
        supporting = sorted(roles.supporting.tolist(), key=lambda option: -int(visits[option]))
        for links, options in (
            (self._supporting, supporting),
            (self._redundant, roles.redundant.tolist()),
        ):
            named: list[tuple[str, Command]] = [
                (f"Option {option}", Select(option)) for option in options[:_MOST_SHOWN]
            ]
            links.sync(named, len(options))

    def _sync_carriers(self, view: View, job: JobState | None) -> None:
        whole = view.whole
        is_busy = job is not None and not job.is_done
        is_shown = is_busy or (self._roles is not None and len(self._roles.deciding) > 0)
        for handle in (
            self._carriers,
            self._row,
            self._options,
            self._episodes,
            self._buttons_row,
            self._mute,
            self._mute_selected,
        ):
            handle.visible = is_shown
        self._options_shown.show(whole.options)
        self._episodes_shown.show(whole.episodes)
        self._muted = whole.options
        label = _END if is_busy else _MUTE
        if self._mute.label != label:
            self._mute.label = label
        self._selected = view.selected
        is_there = view.forest is not None and 0 <= view.selected < len(view.forest.is_alive)
        label = f"Mute option {view.selected}" if is_there else "Mute the selected"
        if self._mute_selected.label != label:
            self._mute_selected.label = label
        self._mute_selected.disabled = is_busy or not is_there
        self._mute_bar.visible = is_busy
        self._mute_bar.value = 100.0 * html_whole.share_of(job)
        self._told_carriers.content = html_whole.carriers(job)
        told = job.latest.told if job is not None and isinstance(job.latest, Playing) else None
        if told is not self._told:
            self._told = told
            muted = told.muted if told is not None else ()
            self._losses.sync([(html_whole.muted_words(one), Select(one.option)) for one in muted])

    def _show(self) -> LookAtWhole:
        is_busy = self._bar.visible
        is_known = self._portrait is not None and self._portrait.is_complete
        return LookAtWhole(begins=not (is_busy or is_known))

    def _look_or_end(self) -> Command:
        return CallOff(Task.WHOLE) if self._look.label == _END else LookAtWhole(begins=True)

    def _mute_or_end(self) -> Command:
        if self._mute.label == _END:
            return CallOff(Task.MUTE)
        roles = self._roles
        return Mute(() if roles is None else tuple(roles.deciding[: self._muted].tolist()))

    def _to_mute_selected(self) -> Mute:
        return Mute((self._selected,))

    def _to_farthest(self) -> ShowMoment | None:
        return None if self._farthest_at is None else ShowMoment(*self._farthest_at)
