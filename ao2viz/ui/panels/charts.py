"""The right dock, below: how training went."""

import time
from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.figures.charts import options_figure, returns_figure, weights_figure
from ao2viz.ui.view import View

_EVERY_S = 1.0  # A growing chart is sent this often.
_PATIENCE_S = 2.5  # Plotly is 1.7 MB; the picture and the path come first.
_CONFIG = {"displayModeBar": False, "responsive": True}
_EMPTY = '<div class="ao"><p class="ao-dim">{}</p></div>'


class ChartsPanel:
    """Return and options over time, and what the selected option expects."""

    def __init__(self, gui: viser.GuiApi, clock: Callable[[], float] = time.monotonic) -> None:
        self._gui, self._clock = gui, clock
        self._began = clock()
        self._sent_at = -np.inf
        self._history: NDArray[np.float64] | None = None
        self._option: tuple[object, ...] = ()
        self._place = gui.add_folder(None)
        with self._place:
            self._words = gui.add_html(_EMPTY.format("The charts are on their way …"))
        self._returns: viser.GuiPlotlyHandle | None = None
        self._options: viser.GuiPlotlyHandle | None = None
        self._weights: viser.GuiPlotlyHandle | None = None

    def sync(self, view: View) -> None:
        """Shows what is new, at most once a second."""
        now = self._clock()
        if now - self._began < _PATIENCE_S or now - self._sent_at < _EVERY_S:
            return
        option = (view.selected, view.forest)
        is_same_option = len(self._option) == 2 and all(
            a is b for a, b in zip(option, self._option, strict=True)
        )
        if view.history is self._history and is_same_option:
            return
        self._sent_at = now
        with self._place:
            self._sync_history(view)
            self._sync_weights(view)
        self._history, self._option = view.history, option

    def _sync_history(self, view: View) -> None:
        has_history = len(view.history) > 0
        self._words.visible = not has_history
        self._words.content = _EMPTY.format(
            "No training episode has ended yet; the charts begin with the first."
        )
        if not has_history:
            for handle in (self._returns, self._options):
                if handle is not None:
                    handle.visible = False
            return
        if view.history is self._history:
            return
        returns = returns_figure(view.history, view.spec)
        options = options_figure(view.history)
        if self._returns is None or self._options is None:
            self._returns = self._gui.add_plotly(returns, config=_CONFIG, aspect=0.72, order=1)
            self._options = self._gui.add_plotly(options, config=_CONFIG, aspect=0.55, order=2)
            return
        self._returns.visible = self._options.visible = True
        self._returns.figure, self._options.figure = returns, options

    def _sync_weights(self, view: View) -> None:
        chosen, forest, spec = view.selected, view.forest, view.spec
        if chosen == NO_OPTION or forest is None or spec is None or chosen >= len(forest.parents):
            if self._weights is not None:
                self._weights.visible = False
            return
        figure = weights_figure(forest.weights[chosen], forest.visits[chosen], spec)
        figure.update_layout(title={"text": f"Option {chosen}", "x": 0.02, "font": {"size": 12}})
        if self._weights is None:
            self._weights = self._gui.add_plotly(figure, config=_CONFIG, aspect=0.6, order=3)
            return
        self._weights.visible = True
        self._weights.figure = figure
