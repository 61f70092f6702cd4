"""The right dock, below: how the forest is shown, and ways to find an option in it."""

from functools import partial

import viser
from viser._messages import HotkeyKey

from ao2viz.envs.task import TaskSpec
from ao2viz.figures.coloring import Coloring
from ao2viz.ui import html
from ao2viz.ui.commands import (
    ChooseArrangement,
    ChooseAxis,
    ChooseColoring,
    Command,
    FindState,
    Fold,
    FoldAll,
    LimitDepth,
    SelectDecided,
    ShowAhead,
    Walk,
    Way,
)
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_trigger
from ao2viz.ui.look import Arrangement
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.typed import names, tell_apart
from ao2viz.ui.view import View

_NO_AXIS = "none"
_KEYS: tuple[tuple[str, Command, HotkeyKey], ...] = (
    ("Forest: the next arrangement", ChooseArrangement(None), "L"),
    ("Forest: colours tell the next thing", ChooseColoring(None), "C"),
    ("Forest: fold or unfold the selected schema", Fold(), "X"),
    ("Forest: fold every schema", FoldAll(True), "O"),
    ("Forest: unfold every schema", FoldAll(False), "U"),
    ("Forest: the imagined path", ShowAhead(None), "R"),
    ("Select: the option that decided", SelectDecided(), "W"),
    ("Select: its parent", Walk(Way.PARENT), "I"),
    ("Select: its child that was visited the most", Walk(Way.CHILD), "K"),
    ("Select: the sibling before", Walk(Way.BEFORE), "J"),
    ("Select: the sibling after", Walk(Way.AFTER), "M"),
)


class ForestPanel:
    """What one browser leaves out of its forest, how it is arranged, and what colours tell."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._spec: TaskSpec | None = None
        self._features: tuple[str, ...] = ()
        put = partial(on_change, client_id=client_id, inbox=inbox)
        arrangements = tuple(a.value for a in Arrangement)
        self._arrangement = gui.add_dropdown("Layout", arrangements)
        put(self._arrangement, lambda v: ChooseArrangement(Arrangement(v)))
        self._axes = [
            gui.add_dropdown(label, (_NO_AXIS,), visible=False)
            for label in ("Across", "Up", "In depth")
        ]
        for place, handle in enumerate(self._axes):
            put(handle, partial(self._to_axis, place))
        self._coloring = gui.add_dropdown("Colour", tuple(c.value for c in Coloring))
        put(self._coloring, lambda v: ChooseColoring(Coloring(v)))
        self._depth = gui.add_slider(
            "Depth", 0, 1, 1, 1, hint="Options further below their root are hidden."
        )
        put(self._depth, self._to_depth)
        gui.add_html(html.row(3))
        for label, command, hint in (
            ("Fold", Fold(), "Shows only the root of the selected option's schema, or all again."),
            ("Fold all", FoldAll(True), "Shows only the roots."),
            ("Unfold all", FoldAll(False), "Shows every schema in full."),
        ):
            on_click(gui.add_button(label, color="gray", hint=hint), command, client_id, inbox)
        self._ahead = gui.add_checkbox(
            "Imagined path", True, hint="Where the agent expects to go from here."
        )
        put(self._ahead, ShowAhead)
        self._state = gui.add_text("Find state", "")
        put(self._state, FindState)
        self._help = gui.add_html("")
        for words, command, key in _KEYS:
            on_trigger(gui.add_command(words, hotkey=key), command, client_id, inbox)
        self._arrangement_shown = Mirror(self._arrangement)
        self._coloring_shown = Mirror(self._coloring)
        self._axes_shown = [Mirror(handle) for handle in self._axes]
        self._depth_shown = Mirror(self._depth)
        self._ahead_shown = Mirror(self._ahead)

    def sync(self, view: View) -> None:
        """Shows what was chosen."""
        look = view.look
        self._arrangement_shown.show(look.arrangement.value)
        self._coloring_shown.show(look.coloring.value)
        self._ahead_shown.show(view.shows_ahead)
        deepest = int(view.forest.depths.max(initial=0)) if view.forest is not None else 0
        limit = deepest if look.deepest is None else min(look.deepest, deepest)
        self._depth_shown.show_within(max(1, deepest), limit)
        self._depth.disabled = deepest == 0
        if view.spec is not self._spec:
            self._spec = view.spec
            features = view.spec.features if view.spec is not None else ()
            self._features = tell_apart([feature.name for feature in features])
            self._help.content = _help(view.spec)
        for place, handle in enumerate(self._axes):
            has_choice = place < len(self._features)
            handle.visible = look.arrangement is Arrangement.STATE_SPACE and has_choice
            if not handle.visible:
                continue
            options = (*self._features, _NO_AXIS) if place == 2 else self._features
            at = look.axes[place] if place < len(look.axes) else None
            self._axes_shown[place].show_among(
                options, self._features[at] if at is not None else _NO_AXIS
            )

    def _to_axis(self, place: int, words: str) -> ChooseAxis | None:
        if words in self._features:
            return ChooseAxis(place, self._features.index(words))
        return ChooseAxis(place, None) if words == _NO_AXIS else None

    def _to_depth(self, deepest: int) -> LimitDepth:
        return LimitDepth(None if deepest >= self._depth.max else deepest)


def _help(spec: TaskSpec | None) -> str:
    if spec is None:
        return ""
    asked = "; ".join(html.esc(name) for name in names(spec))
    return (
        f'<div class="ao ao-dim"><p>To find the option nearest to a state, type its numbers in '
        f"this order, then Enter: {asked}.</p></div>"
    )
