"""The docks, which are the same in every browser; each browser fills them with its own panels."""

import viser

from ao2viz import resources
from ao2viz.ui.scene import prepare

_LEFT_PX, _RIGHT_PX = 300, 340


class Stage:
    """The empty page: theme, style sheet, docks and light."""

    def __init__(self, server: viser.ViserServer) -> None:
        gui = server.gui
        gui.configure_theme(
            dark_mode=True, show_logo=False, show_share_button=False, brand_color=(61, 120, 210)
        )
        css = (resources.static() / "dashboard.css").read_text(encoding="utf-8")
        gui.add_html(f"<style>{css}</style>", order=-1.0)
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
        self.forest = below.add_tab("Forest", viser.Icon.TREES)
        self.charts = below.add_tab("Charts", viser.Icon.CHART_LINE)
        self.what_if = below.add_tab("What if", viser.Icon.ADJUSTMENTS_HORIZONTAL)
        self.compare = below.add_tab("Compare", viser.Icon.ARROWS_DIFF)
        self.export = below.add_tab("Export", viser.Icon.DOWNLOAD)
        below.dock_below(gui.main_panel)
        below.set_width(_RIGHT_PX)
        prepare(server.scene)
