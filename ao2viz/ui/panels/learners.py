"""The learners of the paper's comparison behind a run: chosen in Charts, told there and beside."""

from functools import partial

import viser

from ao2viz.figures.charts import Over
from ao2viz.ui import html, html_learners
from ao2viz.ui.commands import Download, LayBehind, Table
from ao2viz.ui.inbox import Inbox, on_change, on_press, on_trigger
from ao2viz.ui.learners import Learners
from ao2viz.ui.mirror import Mirror

_IN_A_ROW = 2
_ALL: str = "Draw in Charts"
_NOTHING: str = "Take from Charts"


class LearnersPanel:
    """In Charts: what to lay behind the returns, and what that says in words."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._gui, self._client_id, self._inbox = gui, client_id, inbox
        self._place = gui.add_folder("Behind it: the paper's learners", expand_by_default=False)
        with self._place:
            self._words = gui.add_html("")
        self._told = gui.add_html("")
        self._boxes: list[tuple[viser.GuiCheckboxHandle, Mirror]] = []
        self._names: list[str] = []
        key = gui.add_command("Charts: the paper's learners behind the returns, or not")
        on_trigger(key, LayBehind(None), client_id, inbox)

    def sync(self, learners: Learners, over: Over) -> None:
        """Shows the learners of the task that is watched."""
        self._words.content = html_learners.why_none(learners)
        self._names = [one.learner for one in learners.known]
        while len(self._boxes) < len(self._names):
            self._add_boxes()
        for place, (box, shown) in enumerate(self._boxes):
            box.visible = place < len(self._names)
            if box.visible:
                if box.label != self._names[place]:
                    box.label = self._names[place]
                shown.show(self._names[place] in learners.chosen)
        words = html_learners.beside_learners(learners, learners.laid)
        if words and over is not Over.STEPS:
            words = html.notice("The paper's learners stand over steps: choose steps to see them.")
        self._told.content = words

    def _add_boxes(self) -> None:
        """One row more."""
        with self._place:
            self._gui.add_html(html.row(_IN_A_ROW))
            for place in range(len(self._boxes), len(self._boxes) + _IN_A_ROW):
                box = self._gui.add_checkbox(f"Learner {place + 1}", initial_value=False)
                on_change(
                    box, partial(self._lay, place), client_id=self._client_id, inbox=self._inbox
                )
                self._boxes.append((box, Mirror(box)))

    def _lay(self, place: int, is_laid: bool) -> LayBehind | None:
        names = self._names
        return LayBehind(names[place], is_laid) if place < len(names) else None


class BesideLearners:
    """In Compare: where every learner of the task was after as many steps."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        gui.add_html('<div class="ao"><h4>Beside the paper\'s learners</h4></div>')
        self._words = gui.add_html("")
        gui.add_html(html.row(2))
        self._lay = gui.add_button(_ALL, color="gray", hint="Draws their curves in Charts.")
        on_press(self._lay, self._command, client_id=client_id, inbox=inbox)
        self._csv = gui.add_button(
            "Curves CSV", color="gray", hint=f"Saves {Table.LEARNERS.value}."
        )
        on_press(self._csv, lambda: Download(Table.LEARNERS), client_id=client_id, inbox=inbox)

    def sync(self, learners: Learners) -> None:
        """Shows the learners of the task that is watched."""
        none = html_learners.why_none(learners)
        self._words.content = none or html_learners.beside_learners(learners, learners.known)
        self._lay.visible = self._csv.visible = not none
        label = _NOTHING if learners.laid else _ALL
        if self._lay.label != label:
            self._lay.label = label

    def _command(self) -> LayBehind:
        return LayBehind(None, is_laid=self._lay.label == _ALL)
