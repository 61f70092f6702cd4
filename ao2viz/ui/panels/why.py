"""The left dock, below: the decision of the step that is shown, its path and where it leads."""

import viser

from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.ahead import Ahead
from ao2viz.explain.whole import Novelty
from ao2viz.recording.cycle import Stage
from ao2viz.ui import html, html_cycle, html_past, html_reasons, html_replay
from ao2viz.ui.view import View

_OF_NOW = "Below stands the decision of the replay, not what the agent would have chosen then."


class WhyPanel:
    """What the agent did and why."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._said: tuple[object, ...] = ()
        self._told_ahead: Ahead | None = None
        self._asked_why_not: tuple[object, object] = (None, None)
        self._line = gui.add_html("")
        self._cycle = gui.add_html("")
        self._decision = gui.add_html("")
        self._path = gui.add_html("")
        self._ahead = gui.add_html("")
        self._why_not = gui.add_html("")
        self._novelty = gui.add_html("")
        self._faithful = gui.add_html("")

    def sync(
        self,
        view: View,
        problem: str,
        ahead: Ahead | None = None,
        faithful: Faithfulness | None = None,
        novelty: Novelty | None = None,
    ) -> None:
        """Shows the decision; `problem` is why there is no picture of it."""
        self._line.content = html_replay.line(view) + html_past.of_now(view, _OF_NOW)
        self._sync_words(view, problem)
        told = html.faithful(faithful, is_learning=view.learned is None)
        self._faithful.content = told if view.decision is not None else ""
        self._novelty.content = "" if novelty is None else html_reasons.novelty(novelty)
        self._sync_why_not(view)
        if ahead is not self._told_ahead:
            self._told_ahead = ahead
            if ahead is not None and view.spec is not None:
                self._ahead.content = html_reasons.ahead(ahead, view.spec)
            else:
                self._ahead.content = ""

    def _sync_why_not(self, view: View) -> None:
        """What stood against the other actions; told once the replay or the run holds."""
        decision, spec, forest = view.decision, view.spec, view.forest
        if view.learned is None or view.transport.is_playing or view.walk is not None:
            decision = None
        was_asked = self._asked_why_not
        if decision is was_asked[0] and forest is was_asked[1]:
            return
        self._asked_why_not = decision, forest
        self._why_not.content = ""
        if decision is not None and spec is not None and forest is not None:
            self._why_not.content = html_reasons.why_nots(decision, spec, forest)

    def _sync_words(self, view: View, problem: str) -> None:
        supposes = view.supposed is not None and view.back is None
        taken = "" if supposes else html_replay.taken_over(view)
        moment = (view.decision, supposes, view.notice, problem, view.forest_key, taken)
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
            self._decision.content = taken + html.decision(view.decision, view.spec, view.forest)
            self._path.content = html.path(view.decision, view.spec, view.forest)
        else:
            self._decision.content = html.notice(view.notice, is_error=view.is_trouble)
            self._path.content = ""
        if supposes:
            self._decision.content = html.supposing() + self._decision.content
        if problem:
            self._decision.content += html.notice(problem, is_error=True)
