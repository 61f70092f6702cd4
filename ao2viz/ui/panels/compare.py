"""The right dock, below: another agent beside the one that is watched."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import viser

from ao2viz.core.decision import Decision
from ao2viz.envs.task import TaskSpec
from ao2viz.experiments.duel import Beside, Duel
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.compare import Difference, tell_difference
from ao2viz.explain.telling import CHECKS
from ao2viz.explain.whole import Comparison
from ao2viz.explain.words import capitalised
from ao2viz.recording.episode import Episode
from ao2viz.ui import html, html_compare
from ao2viz.ui.commands import Command, Seek, Select
from ao2viz.ui.comparing import Other, begin_beside, beside_subject
from ao2viz.ui.frames import BLANK, FrameStore
from ao2viz.ui.inbox import Inbox, on_change, on_press, on_trigger
from ao2viz.ui.jobs import Jobs, JobState
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.panels.learners import BesideLearners
from ao2viz.ui.panels.links import Links
from ao2viz.ui.questions import CallOff, ChooseDuelSeed, ChooseOther, Fight, SeekDuel, Task
from ao2viz.ui.thinker import Thinker
from ao2viz.ui.view import View

_NOBODY: str = "nobody"
_MOST_SHOWN = 100  # Of each list; their number is told all the same.
_LARGEST_SEED = 2**30 - 1
_END: str = "End"

FrameOf = Callable[[Episode, TaskSpec, int], tuple[bytes | None, str]]
"""The picture of a step of an episode; see `FrameStore.get`."""


class ComparePanel:
    """What one browser compares."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._paths: dict[str, Path] = {}
        self._partings: list[int] = []
        self._position = 0
        self._duel: Duel | None = None
        self._beside: Beside | None = None
        put = partial(on_change, client_id=client_id, inbox=inbox)
        press = partial(on_press, client_id=client_id, inbox=inbox)
        self._with = gui.add_dropdown("With", (_NOBODY,))
        put(self._with, self._to_other)
        self._with_shown = Mirror(self._with)
        self._words = gui.add_html(html_compare.NOTHING_CHOSEN)
        self._now = gui.add_html("")
        make = partial(Links, gui, client_id=client_id, inbox=inbox)
        self._steps = make("Steps where they part, what matters most first", shown=3)
        self._returns = gui.add_html("")
        self._heading = gui.add_html(
            '<div class="ao"><h4>From the same seed</h4></div>', visible=False
        )
        self._row = gui.add_html(html.row(2), visible=False)
        self._seed = gui.add_number("Seed", 1, min=0, max=_LARGEST_SEED, step=1, visible=False)
        put(self._seed, ChooseDuelSeed)
        self._seed_shown = Mirror(self._seed)
        self._play = gui.add_button("Play both", color="gray", visible=False)
        press(self._play, self._play_or_end)
        self._pictures_row = gui.add_html(html.row(2), visible=False)
        self._pictures = [gui.add_image(BLANK, format="jpeg", visible=False) for _ in range(2)]
        self._wide = gui.add_html('<span class="ao-wide"></span>', visible=False)
        self._slider = gui.add_slider("Step of both", 0, 1, 1, 0, visible=False)
        put(self._slider, SeekDuel)
        self._slider_shown = Mirror(self._slider)
        self._part = gui.add_button("Where they part", color="gray", visible=False)
        press(self._part, self._to_parting)
        self._told_duel = gui.add_html("")
        self._duel_returns = gui.add_html("")
        self._forests = gui.add_html("")
        self._lists = {kind: make(capitalised(kind.value), shown=2) for kind in Difference}
        self._settings = gui.add_html("")
        self._learners = BesideLearners(gui, client_id, inbox)
        for words, command in (
            ("Compare: let both agents play from the same seeds", Fight()),
            ("Compare: end their playing", CallOff(Task.DUEL)),
            ("Compare: with nobody", ChooseOther(None)),
        ):
            on_trigger(gui.add_command(words), command, client_id, inbox)
        press(gui.add_command("Compare: the next step where they part", hotkey="5"), self._to_next)
        press(gui.add_command("Compare: where they part from the same seed"), self._to_parting)

    def sync(self, view: View, thinker: Thinker, frames: FrameStore, jobs: Jobs) -> None:
        """Shows what is known by now; begins to compare when there is something new to."""
        self._position = view.transport.position
        self._learners.sync(view.learners)
        self._sync_choice(view)
        other, spec, learned = view.other, view.spec, view.learned
        if other is None or other.agent is None or spec is None or learned is None:
            self._clear(self._why_not(view))
            return
        there: object = None
        here: object = view.decision
        if view.observation is not None and not view.transport.is_playing:
            there = thinker.decision(other.agent.learned, view.observation)
            here = thinker.decision(learned, view.observation) or here
        if isinstance(here, Decision) and isinstance(there, Decision):
            self._now.content = html_compare.at_this_step(here, there, spec)
        elif view.transport.is_playing:
            self._now.content = html.notice("Hold the replay to see what each would do here.")
        subject = beside_subject(learned, view.episode, other.agent)
        job = jobs.look(Task.BESIDE, subject)
        if job is None:
            jobs.begin(begin_beside(learned, view.episode, view.recorded, other.agent))
        faithful = thinker.faithfulness(learned, spec, view.recorded, CHECKS[Comparison])
        self._sync_beside(job, spec, faithful)
        duel = jobs.look(Task.DUEL, (learned, other.agent.learned))
        theme = view.appearance.shown_theme
        self._sync_duel(duel, other, spec, partial(frames.get, theme=theme))

    def _why_not(self, view: View) -> str:
        if view.other is None:
            return html_compare.NOTHING_CHOSEN
        if view.other.words:
            return html.notice(view.other.words)
        return html.notice("Hold the run to compare it, or watch a saved agent.")

    def _sync_choice(self, view: View) -> None:
        env_id = view.spec.env_id if view.spec is not None else ""
        kind = env_id.rpartition("-v")[0] or env_id
        self._paths = {
            item.label: item.path
            for item in view.shelf
            if item.path != view.source and (item.env_id.rpartition("-v")[0] or "") in (kind, "")
        }
        chosen = view.other.path if view.other is not None else None
        shown = next((label for label, path in self._paths.items() if path == chosen), _NOBODY)
        if chosen is not None and shown == _NOBODY:
            shown = chosen.stem
            self._paths[shown] = chosen
        self._with_shown.show_among((_NOBODY, *self._paths), shown)

    def _clear(self, words: str) -> None:
        self._words.content = words
        self._beside = self._duel = None
        self._partings = []
        for handle in (
            self._now,
            self._returns,
            self._told_duel,
            self._duel_returns,
            self._forests,
            self._settings,
        ):
            handle.content = ""
        self._show_duel(is_shown=False, has_episodes=False)
        for links in (self._steps, *self._lists.values()):
            links.sync([])

    def _sync_beside(self, job: JobState | None, spec: TaskSpec, faithful: object) -> None:
        told = job.latest if job is not None and isinstance(job.latest, Beside) else None
        counted = html.faithful(faithful if isinstance(faithful, Faithfulness) else None)
        self._words.content = html_compare.beside(job) + counted
        if told is None or told is self._beside:
            return
        self._beside = told
        self._partings = sorted(moment.place for moment in told.episode.disagreements)
        self._steps.sync(_parting_links(told.episode, spec), len(told.episode.disagreements))
        self._returns.content = html_compare.returns(told)
        self._forests.content = html_compare.forests(told)
        self._settings.content = html_compare.settings(told.settings)
        for kind, links in self._lists.items():
            links.sync(
                [
                    (tell_difference(one, spec), Select(one.here))
                    for one in told.forests.of(kind)[:_MOST_SHOWN]
                ],
                told.forests.counts[kind],
            )

    def _sync_duel(
        self, job: JobState | None, other: Other, spec: TaskSpec, frame_of: FrameOf
    ) -> None:
        is_busy = job is not None and not job.is_done
        label = _END if is_busy else "Play both"
        if self._play.label != label:
            self._play.label = label
        self._seed_shown.show(other.seed)
        duel = job.latest if job is not None and isinstance(job.latest, Duel) else None
        self._duel = duel
        self._show_duel(is_shown=True, has_episodes=duel is not None)
        self._told_duel.content = html_compare.duel(job, other.step, spec)
        self._duel_returns.content = html_compare.duel_returns(job)
        if duel is None:
            return
        last = max(len(duel.one), len(duel.other))
        self._slider_shown.show_within(max(1, last), min(other.step, last))
        for image, episode in zip(self._pictures, (duel.one, duel.other), strict=True):
            frame, _ = frame_of(episode, spec, min(other.step, len(episode)))
            if frame is not None:
                image._data = frame
        self._part.disabled = duel.parting is None

    def _show_duel(self, *, is_shown: bool, has_episodes: bool) -> None:
        for handle in (self._heading, self._row, self._seed, self._play):
            handle.visible = is_shown
        for handle in (
            self._pictures_row,
            *self._pictures,
            self._wide,
            self._slider,
            self._part,
        ):
            handle.visible = is_shown and has_episodes

    def _to_other(self, label: str) -> ChooseOther | None:
        if label == _NOBODY:
            return ChooseOther(None)
        path = self._paths.get(label)
        return None if path is None else ChooseOther(path)

    def _play_or_end(self) -> Command:
        return CallOff(Task.DUEL) if self._play.label == _END else Fight()

    def _to_parting(self) -> SeekDuel | None:
        parting = self._duel.parting if self._duel is not None else None
        return None if parting is None else SeekDuel(parting)

    def _to_next(self) -> Seek | None:
        after = [step for step in self._partings if step > self._position]
        following = after or self._partings
        return Seek(following[0]) if following else None


def _parting_links(told: Comparison, spec: TaskSpec) -> list[tuple[str, Command]]:
    links: list[tuple[str, Command]] = []
    for moment in told.disagreements[:_MOST_SHOWN]:
        here, there = spec.action_names[moment.one], spec.action_names[moment.other]
        links.append((f"Step {moment.place}: {here}, there {there}", Seek(moment.place)))
    return links
