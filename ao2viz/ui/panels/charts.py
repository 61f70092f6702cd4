"""The right dock, below: the episode that is watched, and how training went."""

import time
from collections.abc import Callable
from functools import partial

import numpy as np
import viser

from ao2viz.core.decision import NO_OPTION
from ao2viz.figures.behind import lay_behind
from ao2viz.figures.charts import Over, options_figure, returns_figure, weights_figure
from ao2viz.ui import html
from ao2viz.ui.commands import ChooseOver, ChooseSmoothing, Download, Seek, Table
from ao2viz.ui.html_episode import episode_chart, episode_cursor, episode_words
from ao2viz.ui.inbox import Inbox, on_change, on_click, on_trigger
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.panels.learners import LearnersPanel
from ao2viz.ui.view import View

_EVERY_S = 1.0  # A growing chart is sent this often.
_PATIENCE_S = 2.5  # Plotly is 1.7 MB; the picture and the path come first.
_CONFIG = {"displayModeBar": False, "responsive": True}
_EMPTY = '<div class="ao"><p class="ao-dim">{}</p></div>'
_HEADING = '<div class="ao"><h4>{}</h4></div>'
_IN_A_ROW = 2
_SMOOTHING: dict[str, int] = {"off": 1, "5": 5, "20": 20, "100": 100}


class ChartsPanel:
    """Margin and reward of an episode, return and options of training, an option's weights."""

    def __init__(
        self,
        gui: viser.GuiApi,
        client_id: int,
        inbox: Inbox,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock = clock
        self._episode: tuple[object, ...] = ()
        put = partial(on_change, client_id=client_id, inbox=inbox)
        gui.add_html(_HEADING.format("This episode"))
        self._cursor = gui.add_html("")
        self._chart = gui.add_html("")
        self._numbers = gui.add_html("")
        gui.add_html('<span class="ao-wide"></span>')
        self._slider = gui.add_slider("Step on the chart", 0, 1, 1, 0)
        put(self._slider, Seek)
        self._slider_shown = Mirror(self._slider)
        gui.add_html(_HEADING.format("Training"))
        gui.add_html(html.row(2))
        self._over = gui.add_dropdown("Over", (Over.STEPS.value, Over.EPISODES.value))
        put(self._over, lambda v: ChooseOver(Over(v)))
        self._over_shown = Mirror(self._over)
        self._smoothing = gui.add_dropdown(
            "Mean of", tuple(_SMOOTHING), initial_value="20", hint="Episodes in the running mean."
        )
        put(self._smoothing, lambda v: ChooseSmoothing(_SMOOTHING[v]))
        self._learners = LearnersPanel(gui, client_id, inbox)
        self._training = _TrainingCharts(gui, clock)
        gui.add_html(_HEADING.format("Take away"))
        self._downloads: dict[Table, viser.GuiButtonHandle] = {}
        self._keys: dict[Table, viser.CommandHandle] = {}
        for table, label in (
            (Table.TRAINING, "Training"),
            (Table.EPISODE, "Episode"),
            (Table.OPTION, "Option"),
            (Table.LEARNERS, "Curves"),
        ):
            if len(self._downloads) % _IN_A_ROW == 0:
                gui.add_html(html.row(_IN_A_ROW))
            words = f"Saves the {table.value} as CSV."
            button = gui.add_button(f"{label} CSV", color="gray", hint=words)
            on_click(button, Download(table), client_id, inbox)
            self._downloads[table] = button
            key = gui.add_command(f"Download: the {table.value} as CSV")
            on_trigger(key, Download(table), client_id, inbox)
            self._keys[table] = key

    def sync(self, view: View) -> None:
        """Shows the view; what grows, at most once a second."""
        self._sync_episode(view)
        overs = (Over.STEPS.value, Over.EPISODES.value)
        if np.isfinite(view.seconds).any():
            overs = (*overs, Over.SECONDS.value)
        over = view.charts.over if view.charts.over.value in overs else Over.STEPS
        self._over_shown.show_among(overs, over.value)
        for table, button in self._downloads.items():
            button.disabled = self._keys[table].disabled = table not in view.downloads
        self._learners.sync(view.learners, over)
        self._training.sync(view, over)

    def _sync_episode(self, view: View) -> None:
        transport = view.transport
        self._slider.visible = view.episode is not None
        self._slider_shown.show_within(max(1, transport.last), transport.position)
        shown = (view.episode, view.config, transport.position)
        if self._episode[:2] != shown[:2]:
            self._chart.content = episode_chart(view.episode, view.spec, view.config)
        if shown != self._episode:
            self._episode = shown
            self._cursor.content = episode_cursor(view.episode, transport.position)
            self._numbers.content = episode_words(view.episode, transport.position)


class _TrainingCharts:
    """The charts that plotly draws, made when there is something to show."""

    def __init__(self, gui: viser.GuiApi, clock: Callable[[], float]) -> None:
        self._gui, self._clock = gui, clock
        self._began = clock()
        self._sent_at = -np.inf
        self._history: tuple[object, ...] = ()
        self._option: tuple[object, ...] = ()
        self._place = gui.add_folder(None)
        with self._place:
            self._words = gui.add_html(_EMPTY.format("The charts are on their way …"))
        self._returns: viser.GuiPlotlyHandle | None = None
        self._options: viser.GuiPlotlyHandle | None = None
        self._weights: viser.GuiPlotlyHandle | None = None

    def sync(self, view: View, over: Over) -> None:
        """Shows what is new."""
        now = self._clock()
        if now - self._began < _PATIENCE_S or now - self._sent_at < _EVERY_S:
            return
        theme = view.appearance.shown_theme
        history = (view.history, over, view.charts, theme)
        option = (view.selected, view.forest, theme)
        is_new_history = _differ(history, self._history)
        is_new_option = _differ(option, self._option)
        if not is_new_history and not is_new_option:
            return
        self._sent_at = now
        with self._place:
            if is_new_history:
                self._sync_history(view, over)
            if is_new_option:
                self._sync_weights(view)
        self._history, self._option = history, option

    def _sync_history(self, view: View, over: Over) -> None:
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
        smoothing = view.charts.smoothing
        palette = view.appearance.shown_theme.palette
        returns = returns_figure(view.history, view.spec, over, view.seconds, smoothing, palette)
        if over is Over.STEPS:
            lay_behind(returns, view.learners.laid, view.learners.here, palette)
        options = options_figure(view.history, over, view.seconds, palette)
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
        palette = view.appearance.shown_theme.palette
        weights, visits = forest.weights[chosen], forest.visits[chosen]
        figure = weights_figure(weights, visits, spec, palette)
        figure.update_layout(title={"text": f"Option {chosen}", "x": 0.02, "font": {"size": 12}})
        if self._weights is None:
            self._weights = self._gui.add_plotly(figure, config=_CONFIG, aspect=0.6, order=3)
            return
        self._weights.visible = True
        self._weights.figure = figure


def _differ(one: tuple[object, ...], other: tuple[object, ...]) -> bool:
    """Whether anything is another object; arrays are not compared by what they hold."""
    return len(one) != len(other) or any(
        a is not b and not (isinstance(a, int) and a == b) for a, b in zip(one, other, strict=True)
    )
