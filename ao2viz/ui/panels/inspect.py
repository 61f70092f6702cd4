"""The right dock, below: one option in full, and the options around it."""

from collections.abc import Sequence

import viser

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.ui import html
from ao2viz.ui.commands import Select
from ao2viz.ui.inbox import Inbox, on_change
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.view import View

_SHOWN = 6
_CHOOSE: str = "choose one …"
_HELP = (
    '<div class="ao"><p class="ao-dim">Click an option on the canvas, type its id above, or take '
    "the option that decided.</p></div>"
)


class InspectPanel:
    """The selected option of one browser."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._client_id, self._inbox = client_id, inbox
        self._shown: tuple[object, ...] = ()
        self._decided = NO_OPTION
        self._search = gui.add_number("Option id", 0, min=0, max=10_000_000, step=1)
        self._search_shown = Mirror(self._search)
        on_change(self._search, Select, client_id, inbox)
        self._take = gui.add_button("The option that decided", icon=viser.Icon.TARGET, color="gray")

        @self._take.on_click
        async def _(_: viser.GuiEvent) -> None:
            inbox.put(client_id, Select(self._decided))

        self._facts = gui.add_html(_HELP)
        self._parents = _Links(gui, "Parents", self)
        self._children = _Links(gui, "Children: preferred action", self)

    def sync(self, view: View) -> None:
        """Shows the selected option, or how to select one."""
        decision, forest, spec = view.decision, view.forest, view.spec
        has_path = decision is not None and len(decision.path) > 0
        self._decided = int(decision.path[-1]) if decision is not None and has_path else NO_OPTION
        self._take.disabled = self._decided == NO_OPTION
        shown = (view.selected, forest, view.observation)
        if len(self._shown) == 3 and all(a is b for a, b in zip(shown, self._shown, strict=True)):
            return
        self._shown = shown
        chosen = view.selected
        if forest is None or spec is None or chosen == NO_OPTION:
            self._facts.content = _HELP
            self._parents.sync([], forest, spec)
            self._children.sync([], forest, spec)
            return
        if chosen >= len(forest.parents) or not forest.is_alive[chosen]:
            gone = f"Option {chosen} was cleansed; its id will not be used again."
            self._facts.content = f'<div class="ao"><p>{gone}</p></div>'
            return
        self._search_shown.show(chosen)
        self._facts.content = html.option(chosen, forest, spec, view.observation)
        self._parents.sync(forest.parents_of(chosen).tolist(), forest, spec)
        children = forest.children_of(chosen)
        extra = forest.links[forest.links[:, 0] == chosen, 1]
        busiest = sorted(
            [*children.tolist(), *extra.tolist()], key=lambda i: -int(forest.visits[i].sum())
        )
        self._children.sync(busiest, forest, spec)


class _Links:
    """A few buttons, and a list for what they have no room for, that lead to other options."""

    def __init__(self, gui: viser.GuiApi, title: str, panel: InspectPanel) -> None:
        client_id, inbox = panel._client_id, panel._inbox
        self._title, self._ids = title, list[int]()
        self._heading = gui.add_html("", visible=False)
        self._buttons = []
        for place in range(_SHOWN):
            button = gui.add_button("–", color="gray", visible=False)
            on_click_nth(button, self, place, client_id, inbox)
            self._buttons.append(button)
        self._rest = gui.add_dropdown("More", [_CHOOSE], visible=False)
        on_change(self._rest, _to_option, client_id, inbox)

    def nth(self, place: int) -> int:
        """The option behind a button; NO_OPTION if it has gone meanwhile."""
        return self._ids[place] if place < len(self._ids) else NO_OPTION

    def sync(self, ids: Sequence[int], forest: ForestView | None, spec: TaskSpec | None) -> None:
        """Shows these options, the first ones as buttons."""
        self._ids = list(ids)
        self._heading.visible = len(ids) > 0
        self._heading.content = f'<div class="ao"><h4>{self._title} ({len(ids)})</h4></div>'
        words = [html.related(i, forest, spec) for i in ids] if forest and spec else []
        for place, button in enumerate(self._buttons):
            button.visible = place < len(words)
            if button.visible:
                button.label = words[place]
        rest = tuple(words[_SHOWN:])
        self._rest.visible = bool(rest)
        options = (_CHOOSE, *rest)
        if self._rest.options != options:
            self._rest.options = options
        self._rest.value = _CHOOSE


def on_click_nth(
    button: viser.GuiButtonHandle, links: _Links, place: int, client_id: int, inbox: Inbox
) -> None:
    """Sends the option that stands behind a button at the moment it is pressed."""

    @button.on_click
    async def _(_: viser.GuiEvent) -> None:
        inbox.put(client_id, Select(links.nth(place)))


def _to_option(words: str) -> Select | None:
    return None if words == _CHOOSE else Select(int(words.split(" ", 1)[0]))
