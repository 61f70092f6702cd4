"""The docks, which are the same in every browser; each browser fills them with its own panels."""

import json

import viser
from viser._messages import RunJavascriptMessage

from ao2viz import resources
from ao2viz.figures.palette import DARK, LIGHT, Theme, to_css
from ao2viz.ui.scene import prepare

AGENT = "Agent"
"""The tab of the whole agent."""

_LEFT_PX, _RIGHT_PX = 300, 340


def set_theme(gui: viser.GuiApi, theme: Theme) -> None:
    """Shows all browsers of a server, or the one of a client, in a theme."""
    gui.configure_theme(
        dark_mode=theme is Theme.DARK,
        show_logo=False,
        show_share_button=False,
        brand_color=(61, 120, 210),
    )


def show_tab(gui: viser.GuiApi, name: str) -> None:
    """Opens a tab in the browser whose panels these are. Viser leaves that to people."""
    script = f"window.ao2vizShowTab?.({json.dumps(name)})"
    gui._websock_interface.queue_message(RunJavascriptMessage(source=script))


def _variables() -> str:
    """The palettes for the style sheet; each colour follows the theme of the page."""
    colors = {
        "ink": (DARK.ink, LIGHT.ink),
        "dim": (DARK.dim, LIGHT.dim),
        "page": (DARK.page, LIGHT.page),
        "path": (DARK.path, LIGHT.path),
        "vote": (DARK.votes[1], LIGHT.votes[1]),
        "imagined": (DARK.imagined, LIGHT.imagined),
        "selected": (DARK.selected, LIGHT.selected),
        "warn": (DARK.warn, LIGHT.warn),
        "error": (DARK.error, LIGHT.error),
    }
    return f":root{{{''.join(f'--ao-{name}:{to_css(*both)};' for name, both in colors.items())}}}"


class Stage:
    """The empty page: theme, style sheet, docks and light."""

    def __init__(self, server: viser.ViserServer) -> None:
        gui = server.gui
        set_theme(gui, Theme.DARK)
        css = (resources.static() / "dashboard.css").read_text(encoding="utf-8")
        gui.add_html(f"<style>{_variables()}{css}</style>", order=-1.0)
        script = (resources.static() / "page.js").read_text(encoding="utf-8")
        # Viser hands out its own scripts this way; each browser that comes gets it, once.
        server._websock_server.queue_message(RunJavascriptMessage(source=script))
        left = gui.add_panel()
        self.watch = left.add_tab("Watch", viser.Icon.EYE)
        left.dock_left()
        left.set_width(_LEFT_PX)
        told = gui.add_panel()
        self.why = told.add_tab("Why")
        self.moments = told.add_tab("Moments")
        self.branch = told.add_tab("Branch")
        self.past = told.add_tab("Past")
        told.dock_below(left)
        told.set_width(_LEFT_PX)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_RIGHT_PX)
        below = gui.add_panel()
        self.inspect = below.add_tab("Inspect", viser.Icon.BINARY_TREE)
        self.agent = below.add_tab(AGENT, viser.Icon.USER)
        self.forest = below.add_tab("Forest", viser.Icon.TREES)
        self.charts = below.add_tab("Charts", viser.Icon.CHART_LINE)
        self.what_if = below.add_tab("What if", viser.Icon.ADJUSTMENTS_HORIZONTAL)
        self.compare = below.add_tab("Compare", viser.Icon.ARROWS_DIFF)
        self.export = below.add_tab("Export", viser.Icon.DOWNLOAD)
        below.dock_below(gui.main_panel)
        below.set_width(_RIGHT_PX)
        prepare(server.scene)
