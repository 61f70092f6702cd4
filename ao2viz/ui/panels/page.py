"""How the page itself looks: theme, motion, and what newcomers are told."""

from functools import partial

import viser

from ao2viz.figures.palette import Theme
from ao2viz.ui import html, html_page
from ao2viz.ui.appearance import ChooseMotion, ChooseTheme, DismissHint, SwitchTheme
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_trigger
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.view import View

_HINT_PX = 330
_GAP_PX = 10
_SYSTEM = "as the system"
_THEMES: dict[str, Theme | None] = {_SYSTEM: None, **{theme.value: theme for theme in Theme}}
_MOTIONS: dict[str, bool | None] = {_SYSTEM: None, "nothing glides": True, "things glide": False}
_OF_BROWSER = "This browser remembers it; others choose for themselves."


class PagePanel:
    """The hint of a first visit, over the canvas, and the keys for theme and motion."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._gui, self._client_id, self._inbox = gui, client_id, inbox
        gui.add_html(html_page.OFFLINE)
        self._stillness = gui.add_html("", visible=False)
        self._hint: viser.PanelHandle | None = None
        trigger = partial(on_trigger, client_id=client_id, inbox=inbox)
        trigger(gui.add_command("Page: dark or light", hotkey="C", modifier="shift"), SwitchTheme())
        for label, is_still in (("Page: nothing glides", True), ("Page: things glide", False)):
            trigger(gui.add_command(label), ChooseMotion(is_still))

    def sync(self, view: View) -> None:
        """Shows the hint to those who have not dismissed it."""
        rests = view.appearance.rests
        self._stillness.content = html_page.STILL if rests else ""
        self._stillness.visible = rests
        if not view.appearance.hint_is_gone and self._hint is None:
            self._hint = panel = self._gui.add_panel()
            panel.float(x=_GAP_PX, y=_GAP_PX, width=_HINT_PX)
            with panel.add_tab("New here?"):
                self._gui.add_html(html.no_tab())
                self._gui.add_html(html_page.HINT)
                button = self._gui.add_button(
                    "Got it", color="blue", hint="Never shown again here."
                )
                on_click(button, DismissHint(), self._client_id, self._inbox)
        elif view.appearance.hint_is_gone and self._hint is not None:
            self._hint.remove()
            self._hint = None


class ThemeButton:
    """Switches between dark and light."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        self._button = gui.add_button("Light", icon=viser.Icon.SUN, color="gray", hint=_OF_BROWSER)
        on_click(self._button, SwitchTheme(), client_id, inbox)

    def sync(self, view: View) -> None:
        """Says which theme a press leads to."""
        is_dark = view.appearance.shown_theme is Theme.DARK
        label = "Light" if is_dark else "Dark"
        if self._button.label != label:
            self._button.label = label
            self._button.icon = viser.Icon.SUN if is_dark else viser.Icon.MOON


class AppearanceFields:
    """Theme and motion with all their choices."""

    def __init__(self, gui: viser.GuiApi, client_id: int, inbox: Inbox) -> None:
        gui.add_html(html.row(2))
        theme = gui.add_dropdown("Theme", tuple(_THEMES), hint=_OF_BROWSER)
        on_change(theme, lambda words: ChooseTheme(_THEMES[words]), client_id, inbox)
        motion = gui.add_dropdown("Motion", tuple(_MOTIONS), hint=_OF_BROWSER)
        on_change(motion, lambda words: ChooseMotion(_MOTIONS[words]), client_id, inbox)
        self._theme, self._motion = Mirror(theme), Mirror(motion)

    def sync(self, view: View) -> None:
        """Shows what was chosen."""
        shown = view.appearance
        self._theme.show(next(words for words, of in _THEMES.items() if of is shown.theme))
        self._motion.show(next(words for words, of in _MOTIONS.items() if of is shown.is_still))
