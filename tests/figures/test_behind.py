"""Learners behind a run's returns: what is drawn, and what is read off it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ao2viz.figures.behind import Behind, Here, here_of, lay_behind
from ao2viz.figures.charts import returns_figure
from ao2viz.figures.palette import ACTIONS
from tests.figures.curves import behind
from tests.figures.test_charts import history
from tests.forests import cartpole


def test_a_learner_is_a_mean_and_a_band_behind_everything_else():
    figure = returns_figure(history(100), cartpole())
    own = [trace.name for trace in figure.data]
    lay_behind(figure, [behind("PPO", 0), behind("DAC+PPO", 1)], Here(2000, 33.0, 20))
    names = [trace.name for trace in figure.data]
    assert names[:4] == [None, None, "PPO", "DAC+PPO"]
    assert names[4 : 4 + len(own)] == own
    band, _, line = figure.data[:3]
    assert line.x.tolist() == [100, 1000, 10_000]
    assert line.y.tolist() == [15.0, 60.0, 150.0]
    assert band.y.tolist() == [20.0, 70.0, 200.0, 100.0, 50.0, 10.0]
    assert figure.layout.xaxis.type == "log"
    colors = [trace.line.color for trace in figure.data]
    assert len({*colors[2:4], colors[4]}) == 3, "No line of the run looks like a learner's."
    assert colors[4] == colors[5]
    here = figure.data[-1]
    assert (here.x, here.y, here.text) == ((2000,), (33.0,), ("you are here",))


def test_nothing_chosen_leaves_the_chart_as_it_is():
    figure, plain = (returns_figure(history(9), cartpole()) for _ in range(2))
    lay_behind(figure, [], Here(180, 4.0, 9))
    assert figure == plain


def test_nine_learners_can_be_told_apart():
    looks = {(one.color, one.is_dashed) for one in (behind("x", rank) for rank in range(9))}
    assert len(looks) == 9
    assert not behind("x", len(ACTIONS) - 1).is_dashed
    assert behind("x", len(ACTIONS)).is_dashed


def test_where_the_run_is_is_the_end_of_its_running_mean():
    assert here_of(history(0), 20) is None
    assert here_of(history(5), 20) == Here(100, 2.0, 5)
    assert here_of(history(100), 1) == Here(2000, 49.0, 1)
    figure = returns_figure(history(70), cartpole())
    assert here_of(history(70), 20) == Here(1400, figure.data[1].y[-1], 20)


@pytest.mark.parametrize(
    ("steps", "place"), [(99, None), (100, 0), (999, 0), (1000, 1), (10**6, 2)]
)
def test_a_learner_is_asked_at_the_latest_checkpoint_by_then(steps, place):
    assert behind("PPO", 0).by(steps) == place


@given(st.lists(st.floats(-500, 0), min_size=1, max_size=12), st.floats(-600, 100))
def test_as_good_is_the_first_time_that_it_is_reached(means, level):
    steps = np.arange(1, len(means) + 1)
    one = Behind("E", "L", 0, steps, (0,), np.array([means]))
    first = one.first_at(level)
    if first is None:
        assert max(means) < level
    else:
        assert means[first] >= level > max([-np.inf, *means[:first]])
