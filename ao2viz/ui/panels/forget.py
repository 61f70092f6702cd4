"""The right dock, under What if: what it would decide, had it never learned from an episode."""

from functools import partial

import viser

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.forgetting import Changed, Forgotten
from ao2viz.explain.whole import moment_of
from ao2viz.recording.episode import Episode
from ao2viz.ui import html, html_again
from ao2viz.ui.again import forget_subject
from ao2viz.ui.commands import Command
from ao2viz.ui.inbox import Inbox, on_change, on_press, on_trigger
from ao2viz.ui.jobs import Jobs
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.panels.links import Links
from ao2viz.ui.questions import CallOff, ChooseForgotten, Forget, Task
from ao2viz.ui.replay_commands import ShowMoment
from ao2viz.ui.view import View

_END: str = "End"
_START: str = "Forget it"
_MOST_SHOWN = 100  # Of the changed states; their number is told all the same.
_LARGEST = 10_000_000


class ForgetPanel:
    """Which training episode to forget, and which decisions would be others."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._told: Forgotten | None = None
        self._heading = gui.add_html("")
        gui.add_html(html.row(2))
        self._episode = gui.add_number("Forget", 0, min=0, max=_LARGEST, step=1)
        on_change(self._episode, ChooseForgotten, client_id, inbox)
        self._episode_shown = Mirror(self._episode)
        self._button = gui.add_button(
            _START, color="gray", hint="Learns again without this training episode."
        )
        on_press(self._button, self._forget_or_end, client_id, inbox)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._words = gui.add_html("")
        make = partial(Links, gui, client_id=client_id, inbox=inbox)
        self._changed = make("Decisions that change, what matters most first", shown=3)
        for words, command in (
            ("What if: had it never learned from an episode", Forget()),
            ("What if: end learning again", CallOff(Task.FORGET)),
        ):
            on_trigger(gui.add_command(words), command, client_id, inbox)

    def sync(self, view: View, jobs: Jobs) -> None:
        """Shows how far it is, or what came out."""
        again, spec = view.again, view.spec
        n_episodes = len(again.agent.history) if again.agent is not None else 0
        self._heading.content = html_again.heading(n_episodes, again.problem)
        self._episode_shown.show(again.episode)
        job = jobs.look(Task.FORGET, forget_subject(again)) if again.agent is not None else None
        is_busy = job is not None and not job.is_done
        label = _END if is_busy else _START
        if self._button.label != label:
            self._button.label = label
        self._episode.disabled = bool(again.problem)
        self._button.disabled = bool(again.problem) and not is_busy
        self._bar.visible = is_busy
        self._bar.value = 100.0 * html_again.share_of(job)
        self._words.content = html_again.forgotten(job, spec) if spec is not None else ""
        told = job.latest if job is not None and isinstance(job.latest, Forgotten) else None
        if told is not self._told:
            self._told = told
            links = [] if told is None or spec is None else _links(told, view.recorded, spec)
            total = len(told.changed) if told is not None else None
            self._changed.sync(links, total if links else None)

    def _forget_or_end(self) -> Command:
        return CallOff(Task.FORGET) if self._button.label == _END else Forget()


def _links(
    told: Forgotten, recorded: tuple[Episode, ...], spec: TaskSpec
) -> list[tuple[str, Command]]:
    """The changed states as recorded moments; none where options' values were asked instead."""
    if sum(map(len, recorded)) != len(told.states):
        return []
    most = sorted(told.changed, key=lambda one: -min(one.margin, one.margin_after))[:_MOST_SHOWN]
    moments = [(one, moment_of(one.place, recorded)) for one in most]
    return [(_words(one, *at, spec), ShowMoment(*at)) for one, at in moments if at is not None]


def _words(one: Changed, episode: int, step: int, spec: TaskSpec) -> str:
    before, after = spec.action_names[one.before], spec.action_names[one.after]
    return f"Episode {episode + 1}, step {step}: {before} → {after}"
