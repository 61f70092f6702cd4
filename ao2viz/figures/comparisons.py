"""Named lines in one chart, as a drawing for pages that have no plotly."""

from collections.abc import Sequence
from dataclasses import dataclass

import plotly.graph_objects as go
from numpy.typing import NDArray

from ao2viz.figures.drawing import Drawing
from ao2viz.figures.line_chart import draw_lines

_SIZE = (1060.0, 380.0)


@dataclass(frozen=True, eq=False)
class Line:
    """One line and how it is drawn."""

    name: str  # Empty: it is not in the legend.
    x: NDArray
    y: NDArray
    color: str
    width: float = 2.2
    opacity: float = 1.0


@dataclass(frozen=True)
class Level:
    """A value that lines are compared with."""

    value: float
    text: str


def lines_drawing(
    title: str, across: str, lines: Sequence[Line], level: Level | None = None, *, is_log: bool
) -> Drawing:
    """The lines, the level dashed; `across` names the x axis, which may be logarithmic.

    Raises:
        ValueError: If there is no line.
    """
    if not lines:
        raise ValueError("Expected at least one line, but there are none.")
    figure = go.Figure()
    for line in lines:
        style = {"color": line.color, "width": line.width}
        figure.add_scatter(x=line.x, y=line.y, name=line.name, line=style, opacity=line.opacity)
    if level is not None:
        figure.add_hline(level.value, annotation_text=level.text)
    figure.update_layout(xaxis={"type": "log" if is_log else "linear", "title": across})
    return draw_lines(figure, title, *_SIZE)
