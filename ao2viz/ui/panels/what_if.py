"""The right dock, below: what the agent would do if it saw something else."""

from functools import partial

import numpy as np
import viser
from viser._messages import GuiSliderMark, HotkeyKey

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.ahead import Ahead
from ao2viz.explain.flips import Flip, Flips
from ao2viz.explain.nearest import NearestFlip
from ao2viz.ui import html, html_past, html_reasons, html_what_if
from ao2viz.ui.commands import Command
from ao2viz.ui.dials import Dial
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_press, on_trigger
from ao2viz.ui.jobs import Jobs, JobState
from ao2viz.ui.leaving import Leaving
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.questions import CallOff, FindNearest, StopSupposing, Suppose, SupposeState, Task
from ao2viz.ui.supposing import Answer, why_nothing
from ao2viz.ui.thinker import NoAnswer
from ao2viz.ui.view import View
from ao2viz.ui.what_if import nearest_subject

_OF_NOW = "The agent of now is asked here. The canvas shows the past, not the answer."
_PLAYING = "Hold the replay to see what would flip this."
_KEYS: tuple[tuple[str, Command, HotkeyKey | None], ...] = (
    ("What if: back to the moment of the replay", StopSupposing(), "0"),
    ("What if: search for the nearest flip of all features", FindNearest(), None),
    ("What if: end that search", CallOff(Task.NEAREST), None),
)


class WhatIfPanel:
    """A control for each feature, and what the agent makes of them."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._gui, self._client_id, self._inbox = gui, client_id, inbox
        self._answer: Answer | None = None
        self._said: tuple[object, ...] = ()
        self._built: tuple[TaskSpec, tuple[Dial, ...]] | None = None
        self._found: NearestFlip | None = None
        self._line = gui.add_html("")
        self._banner = gui.add_html("")
        gui.add_html(html.row(3))
        self._reset = gui.add_button("Reset", icon=viser.Icon.ARROW_BACK_UP, color="gray")
        on_click(self._reset, StopSupposing(), client_id, inbox)
        self._search = gui.add_button(
            "Nearest flip",
            color="gray",
            hint="Searches for the least change of all features together; takes up to 30 s.",
        )
        on_press(self._search, self._search_or_end, client_id, inbox)
        self._jump = gui.add_button("Go there", color="gray", hint="Supposes the nearest flip.")
        on_press(self._jump, self._to_nearest, client_id, inbox)
        self._nearest = gui.add_html("")
        self._decision = gui.add_html("")
        self._place = gui.add_folder(None)
        self._dials: list[_DialRow] = []
        self._leaving = Leaving()
        self._certainty = gui.add_html("")
        self._path = gui.add_html("")
        self._ahead = gui.add_html("")
        for words, command, key in _KEYS:
            on_trigger(gui.add_command(words, hotkey=key), command, client_id, inbox)
        trigger = gui.add_command("What if: the nearest flip of one feature", hotkey="4")
        on_press(trigger, self._to_flip, client_id, inbox)
        trigger = gui.add_command("What if: go to the nearest flip that was found")
        on_press(trigger, self._to_nearest, client_id, inbox)

    def sync(self, view: View, asked: Answer | NoAnswer | None, jobs: Jobs) -> None:
        """Shows what is known by now."""
        self._line.content = html_past.of_now(view, _OF_NOW)
        answer = asked if isinstance(asked, Answer) else None
        self._sync_search(view, answer, jobs)
        self._reset.disabled = view.supposed is None
        self._leaving.tick()
        self._place.visible = answer is not None
        if answer is None or view.spec is None or view.observation is None:
            self._answer = None
            self._said = ()
            self._banner.content = html.notice(why_nothing(view, asked))
            for handle in (self._decision, self._certainty, self._path, self._ahead):
                handle.content = ""
            return
        self._build(view.spec, answer.dials)
        self._sync_dials(view, answer)
        said = (answer, view.supposed is None, view.transport.is_playing)
        if self._said and said[0] is self._said[0] and said[1:] == self._said[1:]:
            return
        self._said, self._answer = said, answer
        self._sync_words(view, view.spec, answer)

    def _build(self, spec: TaskSpec, dials: tuple[Dial, ...]) -> None:
        if self._built is not None and self._built[0] is spec and self._built[1] is dials:
            return
        self._built = spec, dials
        for row in self._dials:
            self._leaving.add(row)
        with self._place:
            self._dials = [
                _DialRow(self._gui, spec, d, dial, self._client_id, self._inbox)
                for d, dial in enumerate(dials)
            ]

    def _sync_dials(self, view: View, answer: Answer) -> None:
        assert view.spec is not None
        assert view.observation is not None
        flips = answer.flips if isinstance(answer.flips, Flips) else None
        for d, row in enumerate(self._dials):
            row.sync(float(answer.state[d]), float(view.observation[d]), flips)

    def _sync_words(self, view: View, spec: TaskSpec, answer: Answer) -> None:
        assert view.observation is not None
        changed = [
            feature.name
            for feature, now, was in zip(spec.features, answer.state, view.observation, strict=True)
            if now != was
        ]
        self._banner.content = html_what_if.banner(changed, is_supposed=answer.is_supposed)
        if answer.decision is not None:
            self._decision.content = html.decision(answer.decision, spec, view.forest)
            self._path.content = html.path(answer.decision, spec, view.forest)
        elif view.transport.is_playing:
            self._decision.content = html.notice(_PLAYING)
            self._path.content = ""
        match answer.flips:
            case Flips():
                assert view.forest is not None
                faithful = answer.faithfulness
                self._certainty.content = html_what_if.certainty(
                    answer.flips,
                    faithful if isinstance(faithful, Faithfulness) else None,
                    view.forest.attention,
                    spec,
                )
            case NoAnswer(words):
                self._certainty.content = html.notice(words)
            case None:
                self._certainty.content = html.notice("" if view.transport.is_playing else "…")
        way = answer.ahead
        self._ahead.content = html_reasons.ahead(way, spec) if isinstance(way, Ahead) else ""

    def _sync_search(self, view: View, answer: Answer | None, jobs: Jobs) -> None:
        job: JobState | None = None
        if answer is not None and view.learned is not None:
            job = jobs.look(Task.NEAREST, nearest_subject(view.learned, answer.state))
        is_busy = job is not None and not job.is_done
        label = "End search" if is_busy else "Nearest flip"
        if self._search.label != label:
            self._search.label = label
        self._search.disabled = answer is None
        found = job.latest if job is not None else None
        self._found = found if isinstance(found, NearestFlip) else None
        self._jump.disabled = self._found is None or self._found.flipped is None
        words = html_what_if.nearest(job, view.spec) if view.spec is not None else ""
        self._nearest.content = words

    def _search_or_end(self) -> Command:
        return CallOff(Task.NEAREST) if self._search.label == "End search" else FindNearest()

    def _to_nearest(self) -> SupposeState | None:
        found = self._found
        if found is None or found.flipped is None:
            return None
        return SupposeState(tuple(found.flipped.tolist()))

    def _to_flip(self) -> Suppose | None:
        flips = self._answer.flips if self._answer is not None else None
        nearest = flips.nearest if isinstance(flips, Flips) else None
        return None if nearest is None else Suppose(nearest.feature, nearest.beyond)


class _DialRow:
    """The control of one feature: its name and value, a slider, and a button for each flip."""

    def __init__(
        self,
        gui: viser.GuiApi,
        spec: TaskSpec,
        feature: int,
        dial: Dial,
        client_id: int,
        inbox: Inbox,
    ) -> None:
        self._spec, self._feature, self._dial = spec, feature, dial
        self._scale = spec.features[feature].scale
        self._flips: tuple[Flip | None, Flip | None] = (None, None)
        self._shown: tuple[object, ...] = ()
        self._heading = gui.add_html("")
        self._slider = gui.add_slider(
            spec.features[feature].name, dial.low, dial.high, dial.step, dial.low
        )
        self._slider_shown = Mirror(self._slider)
        on_change(self._slider, self._to_value, client_id, inbox)
        self._row = gui.add_html(html.row(2, "ao-flips"))
        self._buttons = [gui.add_button("–", color="gray", disabled=True) for _ in range(2)]
        for place, button in enumerate(self._buttons):
            on_press(button, partial(self._to_flip, place), client_id, inbox)
        self._handles = (self._heading, self._slider, self._row, *self._buttons)

    def sync(self, value: float, seen: float, flips: Flips | None) -> None:
        """Shows a value in environment units, what was seen, and where the action flips."""
        self._slider_shown.settle(self._dial.nearest(value * self._scale))
        shown = (value, seen, flips)
        if self._shown and shown[:2] == self._shown[:2] and flips is self._shown[2]:
            return
        self._shown = shown
        feature = self._spec.features[self._feature]
        self._heading.content = html_what_if.dial(feature, value, seen)
        both = flips.features[self._feature] if flips is not None else None
        self._flips = (both.less, both.more) if both is not None else (None, None)
        for place, button in enumerate(self._buttons):
            flip = self._flips[place]
            button.disabled = flip is None
            button.label = (
                "…"
                if both is None
                else html_what_if.flip_words(flip, self._spec, is_more=place == 1)
            )
        marks = [flip.border * self._scale for flip in self._flips if flip is not None]
        self._slider._marks = tuple(
            GuiSliderMark(float(np.clip(mark, self._dial.low, self._dial.high)), None)
            for mark in marks
        )

    def hide(self) -> None:
        """Takes it out of sight."""
        for handle in self._handles:
            handle.visible = False

    def remove(self) -> None:
        """Takes it off the page."""
        for handle in self._handles:
            handle.remove()

    def _to_value(self, shown: float) -> Suppose:
        return Suppose(self._feature, float(shown) / self._scale)

    def _to_flip(self, place: int) -> Suppose | None:
        flip = self._flips[place]
        return None if flip is None else Suppose(self._feature, flip.beyond)
