"""Learning curves: what is drawn, with which axes, in which colours."""

import numpy as np
import pytest

from ao2viz.core.decision import DecideBy
from ao2viz.figures.learning_curves import Curve, learning_curves_figure


def curve(env="CartPole-v1", group="anticipating", decide_by=DecideBy.VOTE) -> Curve:
    return Curve(
        env=env,
        group=group,
        decide_by=decide_by,
        steps=np.array([100, 200]),
        middle=np.array([10.0, 20.0]),
        low=np.array([8.0, 15.0]),
        high=np.array([12.0, 25.0]),
        seeds={3: np.array([9.0, np.nan]), 4: np.array([11.0, 20.0])},
    )


def test_a_curve_is_a_line_with_its_interval_and_every_seed():
    band, three, four, middle = learning_curves_figure([curve()]).data
    assert list(middle.x) == [100, 200]
    assert list(middle.y) == [10.0, 20.0]
    assert middle.name == "anticipating, by vote"
    assert "IQM" in middle.hovertemplate
    assert list(band.x) == [100, 200, 200, 100]
    assert list(band.y) == [12.0, 25.0, 15.0, 8.0]
    assert band.fill == "toself"
    np.testing.assert_array_equal(three.y, [9.0, np.nan])
    assert list(four.y) == [11.0, 20.0]
    assert "seed 4" in four.hovertemplate
    assert four.line.width < middle.line.width
    assert [trace.showlegend for trace in (band, three, four, middle)] == [False] * 3 + [True]


def test_every_environment_has_a_chart_of_its_own_and_every_chart_its_titles():
    curves = [curve("CartPole-v1"), curve("Pendulum-v1")]
    figure = learning_curves_figure(curves)
    assert [a.text for a in figure.layout.annotations] == ["CartPole-v1", "Pendulum-v1"]
    assert sorted(trace.xaxis for trace in figure.data) == ["x"] * 4 + ["x2"] * 4
    for axis in (figure.layout.xaxis, figure.layout.xaxis2):
        assert axis.title.text == "steps of the environment"
    for axis in (figure.layout.yaxis, figure.layout.yaxis2):
        assert axis.title.text == "mean return (sum of rewards)"
    assert sum(bool(trace.showlegend) for trace in figure.data) == 1, "One entry for both."


def test_colours_tell_settings_apart_and_dashes_the_ways_of_deciding():
    curves = [
        curve(group=group, decide_by=way) for group in ("levels=3", "levels=4") for way in DecideBy
    ]
    lines = [trace for trace in learning_curves_figure(curves).data if trace.showlegend]
    assert [line.name for line in lines] == [
        "levels=3, by vote", "levels=3, by one path", "levels=4, by vote", "levels=4, by one path",
    ]  # fmt: skip
    three, three_path, four, four_path = (line.line for line in lines)
    assert three.color == three_path.color != four.color == four_path.color
    assert three.dash == four.dash == "solid"
    assert three_path.dash == four_path.dash == "dash"


def test_no_band_veils_a_line():
    figure = learning_curves_figure([curve(group="levels=3"), curve(group="levels=4")])
    kinds = ["band" if t.fill else "middle" if t.showlegend else "seed" for t in figure.data]
    assert kinds == ["band"] * 2 + ["seed"] * 4 + ["middle"] * 2


def test_many_environments_find_room():
    figure = learning_curves_figure([curve(f"Env-v{i}") for i in range(12)])
    assert len({trace.yaxis for trace in figure.data}) == 12


def test_no_curve_makes_no_figure():
    with pytest.raises(ValueError, match="at least one learning curve"):
        learning_curves_figure([])
