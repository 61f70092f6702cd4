"""A few buttons, and a list for what they have no room for, that lead somewhere."""

from collections.abc import Sequence
from functools import partial

import viser

from ao2viz.ui.commands import Command
from ao2viz.ui.inbox import Inbox, on_change, on_press

_SHOWN = 6
_CHOOSE: str = "choose one …"


class Links:
    """Places to go to, each with the words that say so."""

    def __init__(
        self,
        gui: viser.GuiApi,
        title: str,
        client_id: int,
        inbox: Inbox,
        shown: int = _SHOWN,
        more: str = "More",
    ) -> None:
        self._title = title
        self._links: dict[str, Command] = {}
        self._heading = gui.add_html("", visible=False)
        self._buttons = []
        for place in range(shown):
            button = gui.add_button("–", color="gray", visible=False)
            on_press(button, partial(self.nth, place), client_id, inbox)
            self._buttons.append(button)
        self._rest = gui.add_dropdown(more, [_CHOOSE], visible=False)
        on_change(self._rest, self._links_get, client_id, inbox)

    def nth(self, place: int) -> Command | None:
        """What stands behind a button; None if it has gone meanwhile."""
        commands = list(self._links.values())
        return commands[place] if place < len(commands) else None

    def sync(self, links: Sequence[tuple[str, Command]], total: int | None = None) -> None:
        """Shows these, the first ones as buttons; equal words are told apart by a number.

        `total` is told where there are more than these.
        """
        self._links = {}
        for words, command in links:
            name, number = words, 2
            while name in self._links:
                name, number = f"{words} ({number})", number + 1
            self._links[name] = command
        names = list(self._links)
        self._heading.visible = bool(names)
        self._heading.content = (
            f'<div class="ao"><h4>{self._title} ({total or len(names):,})</h4></div>'
        )
        for place, button in enumerate(self._buttons):
            button.visible = place < len(names)
            if button.visible:
                button.label = names[place]
        rest = tuple(names[len(self._buttons) :])
        self._rest.visible = bool(rest)
        options = (_CHOOSE, *rest)
        if self._rest.options != options:
            self._rest.options = options
        self._rest.value = _CHOOSE

    def _links_get(self, words: str) -> Command | None:
        return self._links.get(words)
