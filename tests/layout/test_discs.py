"""Layouts: nothing overlaps, order is kept, and what stands stays where it stands."""

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.decision import NO_OPTION
from ao2viz.layout.discs import EMPTY, Layout, has_regrown, lay_out, schemas_of
from ao2viz.layout.packing import pack_circles
from ao2viz.layout.radial import SPACING
from tests.forests import first, random_view, with_parents

shapes = st.tuples(
    st.integers(1, 250), st.integers(1, 12), st.integers(1, 30), st.integers(0, 10**6)
)


def make(shape):
    n, roots, deepest, seed = shape
    return random_view(n, min(n, roots), deepest, seed)


def assert_spaced(layout: Layout) -> None:
    points = layout.positions[~np.isnan(layout.positions[:, 0])]
    gaps = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    np.fill_diagonal(gaps, np.inf)
    assert gaps.min(initial=np.inf) >= SPACING * (1 - 1e-9)


def assert_contained(view, layout: Layout) -> None:
    """Every living option stands inside the disc of its schema; cleansed ones nowhere."""
    np.testing.assert_array_equal(np.isnan(layout.positions[:, 0]), ~view.is_alive)
    place = {int(root): i for i, root in enumerate(layout.roots)}
    for option in np.flatnonzero(view.is_alive):
        disc = place[int(schemas_of(view)[option])]
        away = np.hypot(*(layout.positions[option] - layout.centres[disc]))
        assert away < layout.radii[disc]


@given(shapes, st.sampled_from([1.0, 1.7]))
@settings(max_examples=60, deadline=None)
def test_a_fresh_arrangement_never_overlaps(shape, room):
    view = make(shape)
    layout = lay_out(view, None, room)
    assert_spaced(layout)
    assert_contained(view, layout)
    centres, radii = layout.centres, layout.radii
    gaps = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1))
    np.fill_diagonal(gaps, np.inf)
    assert (gaps >= radii[:, None] + radii[None]).all(), "Discs overlap."


@given(shapes)
@settings(max_examples=60, deadline=None)
def test_siblings_and_cousins_keep_their_order_around_the_root(shape):
    view = make(shape)
    layout = lay_out(view)
    schemas = schemas_of(view)
    angles = np.zeros(len(view.parents))
    for option in range(len(angles)):
        x, y = layout.positions[option] - layout.positions[schemas[option]]
        angles[option] = (np.arctan2(y, x) - np.pi / 2) % (2 * np.pi)
    for root in layout.roots:
        for depth in range(1, int(view.depths.max()) + 1):
            row = np.flatnonzero((schemas == root) & (view.depths == depth))
            row = row[np.lexsort((row, angles[row]))]
            if depth > 1 and len(row):
                parents = angles[view.parents[row]]
                assert (np.diff(parents) >= -1e-9).all(), "Edges of one depth cross."
            same = view.parents[row][1:] == view.parents[row][:-1]
            assert (np.diff(row)[same] > 0).all(), "Siblings are out of order."


def test_the_biggest_schema_stands_in_the_centre():
    view = random_view(400, roots=6, seed=3)
    layout = lay_out(view)
    biggest = np.argmax(layout.radii)
    np.testing.assert_allclose(layout.centres[biggest], 0, atol=1e-9)


@given(shapes, st.lists(st.integers(1, 60), min_size=1, max_size=5), st.booleans())
@settings(max_examples=40, deadline=None)
def test_nothing_moves_while_a_forest_grows(shape, steps, is_from_nothing):
    view = make(shape)
    n = max(1, len(view.parents) // 3)
    layout = EMPTY if is_from_nothing else lay_out(first(view, n))
    for step in [*steps, 10**6]:
        n = min(len(view.parents), n + step)
        grown = lay_out(first(view, n), layout)
        np.testing.assert_array_equal(grown.positions[: len(layout.positions)], layout.positions)
        assert_spaced(grown)
        assert_contained(first(view, n), grown)
        layout = grown


@given(shapes, st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_nothing_moves_when_options_change_parents_or_are_cleansed(shape, seed):
    view = make(shape)
    layout = lay_out(view)
    rng = np.random.default_rng(seed)
    parents, is_alive = view.parents.copy(), view.is_alive.copy()
    for option in rng.permutation(len(parents))[: len(parents) // 2]:
        # Below an older option, so never in a circle; or a root of its own.
        parents[option] = rng.integers(-1, option) if option else NO_OPTION
    for option in rng.permutation(len(parents))[: len(parents) // 4]:
        is_alive[option] = False
        parents[parents == option] = parents[option]
        parents[option] = NO_OPTION
    changed = with_parents(view, parents, is_alive)
    kept = lay_out(changed, layout)
    np.testing.assert_array_equal(kept.positions[is_alive], layout.positions[is_alive])
    assert np.isnan(kept.positions[~is_alive]).all()
    assert_contained(changed, kept)


def test_a_cleansed_spot_is_free_again():
    view = random_view(60, roots=1, deepest=1)
    layout = lay_out(view)
    is_alive = view.is_alive.copy()
    is_alive[30:] = False
    rest = lay_out(replace(view, is_alive=is_alive), layout)
    regrown = lay_out(view, rest)  # As if 30 new options came.
    assert_spaced(regrown)
    assert regrown.extent < 1.5 * layout.extent


def test_a_regrown_forest_is_told_from_one_that_grew():
    view = random_view(100, roots=4)
    assert not has_regrown(first(view, 40), view)
    parents = view.parents.copy()
    parents[50:] = 0
    regrown = with_parents(view, parents, view.is_alive)
    assert has_regrown(view, regrown)


def test_an_empty_forest_is_laid_out_as_nothing():
    layout = lay_out(first(random_view(5), 0))
    assert len(layout.positions) == len(layout.roots) == 0
    assert lay_out(random_view(5), layout).positions.shape == (5, 2)


@pytest.mark.parametrize(("n", "roots", "deepest"), [(20_000, 60, 4), (3_500, 1, 86)])
def test_big_forests_take_a_moment(n, roots, deepest):
    view = random_view(n, roots, deepest)
    began = time.perf_counter()
    lay_out(view)
    assert time.perf_counter() - began < 0.5


@given(st.lists(st.floats(0.5, 80), min_size=1, max_size=120))
@settings(max_examples=80, deadline=None)
def test_packed_circles_touch_but_never_overlap(radii):
    radii = np.sort(np.array(radii))[::-1]
    centres = pack_circles(radii)
    gaps = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1))
    np.fill_diagonal(gaps, np.inf)
    assert (gaps - radii[:, None] - radii[None]).min(initial=0) > -1e-3
    # Compact: the circles fill a fair share of the circle around them.
    reach = (np.hypot(*centres.T) + radii).max()
    if len(radii) > 12 and radii.max() < 4 * radii.min():
        assert (radii**2).sum() > 0.4 * reach**2
