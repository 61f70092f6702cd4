"""Labels, windows, axes and heights: what stands around and above the discs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.layout.cones import find_heights
from ao2viz.layout.fitting import fit_window
from ao2viz.layout.labels import Side, Words, box_of, place_labels
from ao2viz.layout.state_space import extend_axes, find_ticks, fit_axes

WINDOW = (790.0, 810.0)
points = st.tuples(st.floats(-50, 850), st.floats(-50, 850))


@given(st.lists(points, max_size=20), st.lists(points, max_size=10))
@settings(max_examples=100, deadline=None)
def test_labels_never_overlap_and_never_leave_the_window(at, keep_free):
    labels = [Words(point, (30.0 + 7 * i, 15.0)) for i, point in enumerate(at)]
    sides = place_labels(labels, WINDOW, np.array(keep_free).reshape(-1, 2))
    boxes = [box_of(label, side) for label, side in zip(labels, sides, strict=True) if side]
    for i, (left, top, right, bottom) in enumerate(boxes):
        assert left >= 0 <= top
        assert right <= WINDOW[0]
        assert bottom <= WINDOW[1]
        for other in boxes[:i]:
            apart = left >= other[2] or other[0] >= right or top >= other[3] or other[1] >= bottom
            assert apart


def test_a_label_with_room_is_shown_and_covers_the_least():
    lonely = Words((400.0, 400.0), (100.0, 20.0))
    assert place_labels([lonely], WINDOW, np.empty((0, 2))) == [Side.RIGHT_ABOVE]
    covered = np.array([[450.0, 390.0], [350.0, 390.0], [450.0, 410.0]])
    assert place_labels([lonely], WINDOW, covered) == [Side.LEFT_BELOW]
    crowd = place_labels([lonely] * 7, WINDOW, np.empty((0, 2)))
    assert crowd.count(None) == 3  # Four corners only.


circles = st.lists(
    st.tuples(st.floats(-200, 200), st.floats(-200, 200), st.floats(1, 40)), min_size=1, max_size=40
)


@given(circles, st.sampled_from([(384.0, 768.0), (792.0, 810.0), (1500.0, 700.0)]))
@settings(max_examples=60, deadline=None)
def test_nothing_stands_behind_the_panel_or_out_of_the_window(made, window):
    made, panel, margin = np.array(made), (250.0, 260.0), 14.0
    scale, (x, y) = fit_window(made, window, panel, margin)
    # Pixels from the lower left corner of the window.
    seen = np.column_stack([made[:, :2] - (x, y), made[:, 2]]) * scale
    seen[:, :2] += np.array(window) / 2
    low, high = seen[:, :2] - seen[:, 2:], seen[:, :2] + seen[:, 2:]
    assert low.min() >= margin - 1e-6
    assert (high <= np.array(window) - margin + 1e-6).all()
    beyond = np.maximum(seen[:, :2] - panel, 0)
    assert (np.hypot(*beyond.T) >= seen[:, 2] - 1e-6).all()


def test_a_window_without_a_panel_is_filled():
    made = np.array([[0.0, 0.0, 50.0], [100.0, 0.0, 50.0]])
    scale, middle = fit_window(made, WINDOW, (0.0, 0.0), 20.0)
    assert scale == pytest.approx((790 - 40) / 200)
    assert middle == pytest.approx((50, 0))
    assert fit_window(np.empty((0, 3)), WINDOW, (0.0, 0.0), 20.0)[0] > 0


def test_many_circles_are_covered_by_fewer():
    rng = np.random.default_rng(0)
    many = np.column_stack([rng.normal(scale=90, size=(5_000, 2)), np.full(5_000, 1.5)])
    scale, (x, y) = fit_window(many, WINDOW, (250.0, 260.0), 14.0)
    seen = (many[:, :2] - (x, y)) * scale + np.array(WINDOW) / 2
    assert (seen.min(axis=0) > 14).all()
    assert not ((seen[:, 0] < 250) & (seen[:, 1] < 260)).any()


values = st.integers(2, 60).flatmap(
    lambda n: st.lists(
        st.tuples(*[st.floats(-1e4, 1e4, allow_subnormal=False)] * 3), min_size=n, max_size=n
    )
)


@given(values, st.sampled_from([(0, 1), (2, 0), (1, 2, 0)]))
@settings(max_examples=60, deadline=None)
def test_axes_only_grow_and_move_nothing(made, features):
    made = np.array(made)
    axes = fit_axes(made[: len(made) // 2], features)
    longer = extend_axes(axes, made)
    np.testing.assert_array_equal(longer.place(made), axes.place(made))
    low, high = longer.box
    slack = 1e-6 * (high - low)
    assert (longer.place(made) >= low - slack).all()
    assert (longer.place(made) <= high + slack).all()
    assert extend_axes(longer, made) is longer
    assert np.isfinite(longer.place(made)).all()


def test_a_feature_that_never_varied_has_an_axis_too():
    axes = fit_axes(np.zeros((5, 2)), (0, 1))
    assert (axes.high > axes.low).all()
    np.testing.assert_allclose(axes.place(np.zeros((1, 2))), 0)
    assert len(fit_axes(np.empty((0, 2)), (0, 1)).low) == 2


@given(st.floats(-1e5, 1e5), st.floats(1e-3, 1e5))
@settings(max_examples=100, deadline=None)
def test_ticks_are_few_round_and_inside(low, width):
    ticks = find_ticks(low, low + width)
    assert 1 <= len(ticks) <= 12
    slack = 1e-6 * max(width, abs(low))
    assert ticks.min() >= low - slack
    assert ticks.max() <= low + width + slack


def test_the_deeper_an_option_the_lower_it_stands():
    heights = find_heights(np.arange(200))
    assert heights[0] == 0
    assert (np.diff(heights) < 0).all()
    assert heights[86] > -250  # A chain of 86, as the paper's agents make, is no pole.
