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


@pytest.mark.parametrize("start", [1.0, 1_000.0])
@pytest.mark.parametrize("height", [1.02, 0.98])
def test_the_words_of_a_level_stand_where_no_line_crosses_them(start, height):
    # The first line makes the axes; the other runs along the level, at one of its ends.
    lines = [
        Line("far", np.array([1.0, 10_000.0]), np.array([0.0, 0.2]), "#112233"),
        Line("near", np.array([start, 5 * start]), np.array([height, height]), "#445566"),
    ]
    drawing = lines_drawing("title", "steps", lines, Level(1.0, "enough"), is_log=True)
    (words,) = (s for s in drawing.shapes if isinstance(s, Text) and s.text == "enough")
    near = [s for s in drawing.shapes if isinstance(s, Polyline)][1].points
    first = words.x if words.anchor == "start" else words.x - 60
    assert 0 <= first <= drawing.width - 60
    is_beside = near[-1, 0] < first or near[0, 0] > first + 60
    is_clear = not words.y - 13 <= near[0, 1] <= words.y
    assert is_beside or is_clear


def test_no_lines_are_refused():
    with pytest.raises(ValueError, match="Expected at least one line, but there are none"):
        lines_drawing("title", "steps", [], is_log=False)
