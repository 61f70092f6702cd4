"""Figures: what they show, in which units, and in colours everybody can tell apart."""

import colorsys
from dataclasses import replace

import numpy as np
import pytest

from ao2viz.figures.charts import (
    MAX_POINTS,
    Over,
    options_figure,
    returns_figure,
    weights_figure,
)
from ao2viz.figures.palette import ACTIONS, PATH, UNTRIED, action_colors, to_hex
from tests.forests import cartpole, pendulum


def history(n: int) -> np.ndarray:
    steps = np.cumsum(np.full(n, 20.0))
    return np.column_stack([steps, np.arange(n) % 50, np.full(n, 20.0), np.arange(n)])


def test_returns_are_shown_raw_and_smoothed_over_steps_with_the_known_marks():
    figure = returns_figure(history(100), cartpole())
    raw, smooth = figure.data
    np.testing.assert_array_equal(raw.x, history(100)[:, 0])
    np.testing.assert_array_equal(raw.y, history(100)[:, 1])
    assert smooth.y[99] == np.mean(history(100)[80:, 1])
    assert smooth.y[0] == raw.y[0]
    assert figure.layout.xaxis.title.text == "steps"
    assert figure.layout.yaxis.title.text == "return"
    assert [a.text for a in figure.layout.annotations] == ["solved 475"]


def test_the_papers_score_is_a_line_with_a_real_minus():
    figure = returns_figure(history(10), pendulum())
    assert "paper −196.6" in [a.text for a in figure.layout.annotations]


def test_words_of_lines_that_lie_close_stand_on_either_side_of_them():
    spec = cartpole()
    both = replace(spec, entry=replace(spec.entry, solved_at=195.0, paper_score=194.0))
    upper, lower = returns_figure(history(10), both).layout.annotations
    assert (upper.text, upper.y, upper.yanchor) == ("solved 195", 195.0, "bottom")
    assert (lower.text, lower.y, lower.yanchor) == ("paper 194", 194.0, "top")


def test_long_histories_are_thinned_but_keep_their_ends():
    figure = returns_figure(history(30_000), None)
    assert len(figure.data[0].x) == MAX_POINTS
    assert figure.data[0].x[0] == 20
    assert figure.data[0].x[-1] == 600_000


def test_an_empty_history_makes_an_empty_figure():
    assert len(returns_figure(history(0), cartpole()).data[0].x) == 0
    assert len(options_figure(history(0)).data[0].x) == 0


def test_options_are_shown_over_steps():
    figure = options_figure(history(30))
    np.testing.assert_array_equal(figure.data[0].y, np.arange(30))
    assert figure.layout.yaxis.title.text == "options"


def test_weights_leave_out_what_was_never_tried():
    figure = weights_figure(np.array([3.0, 9.0]), np.array([4, 0]), cartpole())
    bars = figure.data[0]
    assert list(bars.y) == ["push left", "push right"]
    assert bars.x[0] == 3.0
    assert np.isnan(bars.x[1])
    assert list(bars.text) == ["4 visits", "never tried"]


def test_figures_have_no_background_of_their_own():
    for figure in (returns_figure(history(3), None), options_figure(history(3))):
        assert figure.layout.paper_bgcolor == figure.layout.plot_bgcolor == "rgba(0,0,0,0)"


def hue(rgb) -> tuple[float, float]:
    h, _, s = colorsys.rgb_to_hls(*(v / 255 for v in rgb))
    return h * 360, s


def test_the_paths_hue_is_used_by_no_colouring():
    path, _ = hue(PATH)
    used = [*ACTIONS, UNTRIED, *action_colors(7, is_ordered=True)]
    for rgb in used:
        other, saturation = hue(rgb)
        away = min(abs(path - other), 360 - abs(path - other))
        assert saturation < 0.2 or away > 45, to_hex(rgb)


def simulate_deuteranopia(rgb) -> np.ndarray:
    """Vienot, Brettel and Mollon's projection for the most frequent colour blindness."""
    linear = (np.array(rgb) / 255) ** 2.2
    matrix = [[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]]
    return np.clip(matrix @ linear, 0, 1) ** (1 / 2.2) * 255


def test_two_and_three_actions_differ_for_colour_blind_eyes():
    for n, ordered in ((2, False), (3, False), (3, True)):
        seen = [simulate_deuteranopia(rgb) for rgb in action_colors(n, is_ordered=ordered)]
        for i in range(n):
            for j in range(i):
                assert np.abs(seen[i] - seen[j]).max() > 50


def test_ordered_actions_run_from_blue_to_orange_and_many_actions_have_colours():
    colors = action_colors(5, is_ordered=True)
    assert tuple(colors[0]) == ACTIONS[0]
    assert tuple(colors[-1]) == ACTIONS[1]
    assert len(np.unique(action_colors(12, is_ordered=False), axis=0)) == 12


@pytest.mark.parametrize(
    ("over", "last", "title"),
    [
        (Over.STEPS, 600.0, "steps"),
        (Over.EPISODES, 30.0, "episodes"),
        (Over.SECONDS, 15.0, "seconds of training, without pauses"),
    ],
)
def test_training_stands_over_steps_episodes_or_seconds(over, last, title):
    seconds = np.arange(1, 31) / 2
    for figure in (
        returns_figure(history(30), None, over, seconds),
        options_figure(history(30), over, seconds),
    ):
        assert figure.data[0].x[-1] == last
        assert figure.layout.xaxis.title.text == title


def test_what_nobody_timed_has_no_place_over_seconds():
    figure = returns_figure(history(4), None, Over.SECONDS, np.array([np.nan, 2.0]))
    np.testing.assert_array_equal(figure.data[0].x, [np.nan, 2.0, np.nan, np.nan])


def test_smoothing_is_over_as_many_episodes_as_asked():
    assert returns_figure(history(100), None, smoothing=5).data[1].y[99] == np.mean(
        history(100)[95:, 1]
    )
    assert len(returns_figure(history(100), None, smoothing=1).data) == 1
