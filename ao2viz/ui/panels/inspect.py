"""The right dock, below: one option in full, why its weights are what they are, what is around."""

from functools import partial

import viser
from viser._messages import HotkeyKey, KeyModifier

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.origin import Origin
from ao2viz.explain.telling import CHECKS
from ao2viz.explain.uses import Use, find_uses
from ao2viz.explain.words import percent
from ao2viz.ui import html, html_again, html_past, html_reasons
from ao2viz.ui.again import ledger_subject
from ao2viz.ui.asking import faithful_of
from ao2viz.ui.commands import (
    Command,
    GoBack,
    GoForward,
    OpenWeight,
    Select,
    SelectDecided,
)
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_press, on_trigger
from ao2viz.ui.jobs import Jobs
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.panels.links import Links
from ao2viz.ui.questions import CallOff, ExportOption, KeepLedger, Task
from ao2viz.ui.replay_commands import ShowMoment
from ao2viz.ui.thinker import NoAnswer, Thinker
from ao2viz.ui.typed import tell_apart
from ao2viz.ui.view import View

_CLOSED: str = "closed"
_LEDGER: str = "Open the ledger"
_END: str = "End"
_MOST_USES = 200  # In the list of moments; their number is told all the same.
# Made once: the panel shows anew what is another object.
_NOT_NOW = NoAnswer("A weight can be opened while the run is held, and in saved agents.")
_MADE_OF_REWARDS = NoAnswer(
    "This weight is made of rewards. The ledger names every one of them; it learns the agent "
    "again, which takes as long as learning did."
)
_HELP = (
    '<div class="ao"><p class="ao-dim">Click an option on the canvas, type its id above, or take '
    "the option that decided.</p></div>"
)
_OF_NOW = "Below stands the option as it is now, not as it was at the moment on the canvas."
_KEYS: tuple[tuple[str, Command, HotkeyKey | None, KeyModifier | None], ...] = (
    ("Inspect: back to what was selected before", GoBack(), "Z", None),
    ("Inspect: forward again", GoForward(), "Z", "shift"),
    ("Inspect: save the selected option", ExportOption(), None, None),
)


class InspectPanel:
    """The selected option of one browser."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._shown: tuple[object, ...] = ()
        self._uses: tuple[object, ...] = ()
        gui.add_html(html.row(3))
        self._back = gui.add_button("Back", icon=viser.Icon.ARROW_LEFT, color="gray")
        on_click(self._back, GoBack(), client_id, inbox)
        self._forward = gui.add_button("Forward", icon=viser.Icon.ARROW_RIGHT, color="gray")
        on_click(self._forward, GoForward(), client_id, inbox)
        self._take = gui.add_button(
            "Decided", icon=viser.Icon.TARGET, color="gray", hint="The option that decided."
        )
        on_click(self._take, SelectDecided(), client_id, inbox)
        self._search = gui.add_number("Option id", 0, min=0, max=10_000_000, step=1)
        self._search_shown = Mirror(self._search)
        on_change(self._search, Select, client_id, inbox)
        self._line = gui.add_html("")
        self._facts = gui.add_html(_HELP)
        self._save = gui.add_button(
            "Save this option",
            icon=viser.Icon.DOWNLOAD,
            color="gray",
            visible=False,
            hint="Its value, weights, their reasons, experience and uses, as a page of notes.",
        )
        on_click(self._save, ExportOption(), client_id, inbox)
        self._actions: tuple[str, ...] = ()
        self._weight = gui.add_dropdown(
            "Open weight", [_CLOSED], visible=False, hint="Why a weight is what it is."
        )
        on_change(self._weight, self._to_weight, client_id, inbox)
        self._weight_shown = Mirror(self._weight)
        self._reasons = gui.add_html("", visible=False)
        self._ledger = gui.add_button(
            _LEDGER,
            color="gray",
            visible=False,
            hint="Learns the agent again and writes down every reward in this weight.",
        )
        on_press(self._ledger, self._account_or_end, client_id, inbox)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._account = gui.add_html("")
        make = partial(Links, gui, client_id=client_id, inbox=inbox)
        self._ends = make("Leads to: share, worth")
        self._moments = make("Recorded moments with a say", shown=3)
        self._parents = make("Parents")
        self._children = make("Children: preferred action")
        for words, command, key, modifier in _KEYS:
            trigger = gui.add_command(words, hotkey=key, modifier=modifier)
            on_trigger(trigger, command, client_id, inbox)

    def sync(self, view: View, thinker: Thinker, jobs: Jobs) -> None:
        """Shows the selected option, or how to select one."""
        self._sync_ledger(view, jobs)
        self._line.content = html_past.of_now(view, _OF_NOW)
        decision, forest, spec = view.decision, view.forest, view.spec
        self._take.disabled = decision is None or len(decision.path) == 0
        self._back.disabled = not view.can_go_back
        self._forward.disabled = not view.can_go_forward
        origin = self._ask(view, thinker)
        faithful = (
            faithful_of(view, thinker, CHECKS[Origin]) if isinstance(origin, Origin) else None
        )
        shown = (view.selected, view.opened, forest, view.observation, origin, faithful)
        if len(self._shown) == len(shown) and all(
            a is b for a, b in zip(shown, self._shown, strict=True)
        ):
            return
        self._shown = shown
        chosen = view.selected
        if forest is None or spec is None or chosen == NO_OPTION:
            self._clear(_HELP)
            return
        if chosen >= len(forest.parents) or not forest.is_alive[chosen]:
            gone = f"Option {chosen} was cleansed; its id will not be used again."
            self._clear(f'<div class="ao"><p>{gone}</p></div>')
            return
        self._search_shown.show(chosen)
        is_brief = view.opened is not None  # Its reasons need the room.
        self._facts.content = html.option(chosen, forest, spec, view.observation, is_brief=is_brief)
        self._sync_weight(view, spec, origin, faithful)
        self._sync_moments(view, spec)
        self._sync_relations(chosen, forest, spec)

    def _sync_ledger(self, view: View, jobs: Jobs) -> None:
        """The rewards in the weight that is open, where weights are made of rewards."""
        again = view.again
        self._ledger.visible = again.weight is not None
        job = jobs.look(Task.LEDGER, ledger_subject(again)) if again.weight is not None else None
        is_busy = job is not None and not job.is_done
        label = _END if is_busy else _LEDGER
        if self._ledger.label != label:
            self._ledger.label = label
        self._bar.visible = is_busy
        self._bar.value = 100.0 * html_again.share_of(job)
        self._account.content = "" if view.spec is None else html_again.account(job, view.spec)

    def _account_or_end(self) -> Command:
        return CallOff(Task.LEDGER) if self._ledger.label == _END else KeepLedger()

    def _ask(self, view: View, thinker: Thinker) -> Origin | NoAnswer | None:
        if view.opened is None or view.selected == NO_OPTION:
            return None
        if view.again.weight is not None:
            return _MADE_OF_REWARDS
        if view.learned is None:
            return _NOT_NOW
        return thinker.origin(view.learned, view.selected, view.opened)

    def _sync_weight(
        self,
        view: View,
        spec: TaskSpec,
        origin: Origin | NoAnswer | None,
        faithful: Faithfulness | None,
    ) -> None:
        self._actions = tell_apart(spec.action_names)
        opened = _CLOSED if view.opened is None else self._actions[view.opened]
        self._weight.visible = self._save.visible = True
        self._weight_shown.show_among((_CLOSED, *self._actions), opened)
        self._reasons.visible = view.opened is not None
        links: list[tuple[str, Command]] = []
        match origin:
            case Origin():
                self._reasons.content = html_reasons.reasons(origin, spec) + html.faithful(faithful)
                links = [
                    (html_reasons.end_words(end), Select(end.option))
                    for end in sorted(origin.ends, key=lambda end: -end.share)
                ]
            case NoAnswer(words):
                self._reasons.content = html.notice(words)
            case None:
                self._reasons.content = html.notice("Imagining it anew …")
        self._ends.sync(links)

    def _sync_moments(self, view: View, spec: TaskSpec) -> None:
        asked = (view.recorded, view.selected, view.opened)
        if len(self._uses) == len(asked) and all(
            a is b for a, b in zip(asked, self._uses, strict=True)
        ):
            return
        self._uses = asked
        found = find_uses(view.recorded, view.selected, view.opened)
        self._moments.sync(
            [(_use_words(use, spec), ShowMoment(use.episode, use.step)) for use in found][
                :_MOST_USES
            ]
        )

    def _sync_relations(self, chosen: int, forest: ForestView, spec: TaskSpec) -> None:
        parents = forest.parents_of(chosen).tolist()
        children = forest.children_of(chosen)
        extra = forest.links[forest.links[:, 0] == chosen, 1]
        busiest = sorted(
            [*children.tolist(), *extra.tolist()], key=lambda i: -int(forest.visits[i].sum())
        )
        for links, ids in ((self._parents, parents), (self._children, busiest)):
            links.sync([(html.related(i, forest, spec), Select(i)) for i in ids])

    def _clear(self, words: str) -> None:
        self._facts.content = words
        self._weight.visible = self._reasons.visible = self._save.visible = False
        self._uses = ()
        for links in (self._ends, self._moments, self._parents, self._children):
            links.sync([])

    def _to_weight(self, words: str) -> OpenWeight | None:
        if words in self._actions:
            return OpenWeight(self._actions.index(words))
        return OpenWeight(None) if words == _CLOSED else None


def _use_words(use: Use, spec: TaskSpec) -> str:
    had = "decided" if use.share == 1 else f"{percent(use.share)} of the say"
    return f"Episode {use.episode + 1}, step {use.step}: {had}, {spec.action_names[use.action]}"
