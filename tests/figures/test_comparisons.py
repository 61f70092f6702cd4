"""Charts of several lines: where they lie, what is named, and axes that are logarithmic."""

import numpy as np
import pytest

from ao2viz.figures.comparisons import Level, Line, lines_drawing
from ao2viz.figures.drawing import Polyline, Text


def drawn(*, is_log: bool, level: Level | None = None):
    x = np.array([100.0, 1000.0, 10_000.0])
    lines = [
        Line("rising", x, np.array([0.0, 1.0, 2.0]), "#112233"),
        Line("", x, np.array([2.0, 1.0, 0.0]), "#445566", opacity=0.5),
    ]
    return lines_drawing("title", "steps", lines, level, is_log=is_log)


def test_equal_ratios_are_equally_far_apart_on_a_logarithmic_axis():
    log, plain = (
        next(shape for shape in drawn(is_log=is_log).shapes if isinstance(shape, Polyline))
        for is_log in (True, False)
    )
    first, second = np.diff(log.points[:, 0])
    assert first == pytest.approx(second)
    first, second = np.diff(plain.points[:, 0])
    assert second == pytest.approx(10 * first)


def texts(drawing) -> list[str]:
    return [shape.text for shape in drawing.shapes if isinstance(shape, Text)]


def test_lines_levels_and_ticks_are_named():
    found = texts(drawn(is_log=True, level=Level(1.5, "enough")))
    assert {"rising", "enough", "steps", "100", "1,000", "10,000"} <= set(found)


def test_no_lines_are_refused():
    with pytest.raises(ValueError, match="Expected at least one line, but there are none"):
        lines_drawing("title", "steps", [], is_log=False)
