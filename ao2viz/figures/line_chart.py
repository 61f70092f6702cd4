"""Line charts as drawings, for pages that have no plotly: the lines of a plotly figure, drawn."""

from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from ao2viz.explain.words import number
from ao2viz.figures.drawing import Drawing, Polyline, Segments, Shape, Text

LEFT, RIGHT, TOP, BOTTOM = 64.0, 28.0, 36.0, 40.0
"""From the edge of a chart to its lines."""

_SIZE = 13.0
_LETTER = 7.5  # Width, roughly: the reader's browser has the font.
_TICKS = 5


def draw_lines(figure: go.Figure, title: str, width: float, height: float) -> Drawing:
    """The lines and level marks of a figure with one x and one y axis.

    Colours, names, axis titles and thinning are the figure's; ink is the page's own.
    """
    traces: Any = figure.data  # plotly's own types say less than is there.
    layout: Any = figure.layout
    lines = [
        (np.asarray(trace.x, np.float64), np.asarray(trace.y, np.float64), trace)
        for trace in traces
    ]
    levels = [float(mark.y0) for mark in layout.shapes if mark.y0 == mark.y1]
    xs = np.concatenate([x for x, _, _ in lines])
    ys = np.concatenate([*(y for _, y, _ in lines), np.array(levels)])
    across = _Axis(xs, LEFT, width - RIGHT, is_log=layout.xaxis.type == "log")
    up = _Axis(ys, height - BOTTOM, TOP)
    shapes: list[Shape] = []
    for value in up.ticks():
        y = float(up.place(np.array(value)))
        ends = np.array([[[LEFT, y], [width - RIGHT, y]]])
        shapes.append(Segments(ends, "currentColor", 1, 0.22))
        shapes.append(Text(LEFT - 8, y + 4, _label(value), _SIZE, "currentColor", anchor="end"))
    for value in across.ticks():
        x = float(across.place(np.array(value)))
        shapes.append(
            Text(x, height - BOTTOM + 18, _label(value), _SIZE, "currentColor", anchor="middle")
        )
    middle = (LEFT + width - RIGHT) / 2
    axis_title = layout.xaxis.title.text or ""
    shapes.append(Text(middle, height - 4, axis_title, _SIZE, "currentColor", anchor="middle"))
    at, drawn = LEFT, []
    for x, y, trace in lines:
        points = np.column_stack([across.place(x), up.place(y)])
        drawn.append(points)
        color, opacity = trace.line.color, trace.opacity or 1.0
        shapes.append(Polyline(points, color, float(trace.line.width or 2), opacity))
        if len(lines) > 1 and trace.name:
            swatch = np.array([[[at, 14.0], [at + 18, 14.0]]])
            shapes.append(Segments(swatch, color, 3, opacity))
            shapes.append(Text(at + 24, 18, trace.name, _SIZE, "currentColor"))
            at += 48 + _LETTER * len(trace.name)
    for level, mark in zip(levels, layout.annotations, strict=False):
        y = float(up.place(np.array(level)))
        dashes = np.arange(LEFT, width - RIGHT - 6, 12.0)
        ends = np.stack(
            [
                np.column_stack([dashes, np.full_like(dashes, y)]),
                np.column_stack([dashes + 6, np.full_like(dashes, y)]),
            ],
            axis=1,
        )
        shapes.append(Segments(ends, "currentColor", 1.2))
        # The lowest one's words go below its line, so that two close ones stay apart.
        sides = (False, True) if len(levels) == 1 else (level == min(levels),)
        shapes.append(_put_words(mark.text or "", y, sides, width, drawn))
    return Drawing(width, height, tuple(shapes), title, "none")


def _put_words(
    words: str, y: float, sides: tuple[bool, ...], width: float, lines: list[NDArray[np.float64]]
) -> Text:
    """Words at either end of a level, above it or (True) below, where the fewest lines cross them.

    Args:
        words: What the level is.
        y: Of the level, in pixels.
        sides: Of the level that may be taken, the first where it makes no difference.
        width: Of the chart.
        lines: [N, 2] points of each, in pixels.
    """
    long = _LETTER * len(words)
    left, right = LEFT + 4, width - RIGHT - 4

    def count_crossed(place: tuple[bool, str]) -> int:
        is_below, anchor = place
        first = left if anchor == "start" else right - long
        top = y + 3 if is_below else y - 5 - _SIZE
        x = np.linspace(first, first + long, 64)
        heights = [np.interp(x, *line.T, left=np.nan, right=np.nan) for line in lines]
        return sum(bool(((at >= top) & (at <= top + _SIZE + 2)).any()) for at in heights)

    places = [(is_below, anchor) for anchor in ("start", "end") for is_below in sides]
    is_below, anchor = min(places, key=count_crossed)
    x = left if anchor == "start" else right
    return Text(x, y + 15 if is_below else y - 5, words, _SIZE, "currentColor", anchor=anchor)


class _Axis:
    """From values to pixels; a logarithmic one is for values above 0."""

    def __init__(
        self, values: NDArray[np.float64], first: float, last: float, *, is_log: bool = False
    ) -> None:
        self._is_log = is_log
        finite = self._scaled(values[np.isfinite(values)])
        self._low = float(finite.min()) if len(finite) else 0.0
        self._high = float(finite.max()) if len(finite) else 1.0
        if self._high == self._low:
            self._low, self._high = self._low - 0.5, self._high + 0.5
        self._first, self._last = first, last

    def place(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        share = (self._scaled(values) - self._low) / (self._high - self._low)
        return self._first + share * (self._last - self._first)

    def _scaled(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.log10(values) if self._is_log else values

    def ticks(self) -> list[float]:
        """A few round values within the axis."""
        if self._is_log:
            low, high = 10**self._low, 10**self._high
            decades = range(int(np.floor(self._low)), int(np.ceil(self._high)) + 1)
            rounds = [m * 10.0**k for k in decades for m in (1, 2, 5)]
            return [value for value in rounds if low <= value <= high]
        rough = (self._high - self._low) / _TICKS
        scale = 10.0 ** np.floor(np.log10(rough))
        step = scale * next(m for m in (1, 2, 5, 10) if m * scale >= rough)
        first = np.ceil(self._low / step - 1e-9)
        last = np.floor(self._high / step + 1e-9)
        return [float(k * step) + 0.0 for k in np.arange(first, last + 1)]  # No minus before 0.


def _label(value: float) -> str:
    """A tick's value as short as it can be."""
    if value == round(value) and abs(value) < 1e6:
        return f"{value:,.0f}".replace("-", "−")
    text = number(value)
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text
