"""Colours of options: what they say, and that everybody can tell them apart."""

from dataclasses import replace

import numpy as np
import pytest

from ao2viz.figures.coloring import NEIGHBOURS, Coloring, find_agreement, shade
from ao2viz.figures.palette import ACTIONS, IMAGINED, PATH, RAMP, UNTRIED, along_ramp
from tests.forests import cartpole, random_view, small_view

SPEC = cartpole()


def luminance(rgb) -> float:
    """Relative luminance as WCAG 2.2 defines it."""
    srgb = np.asarray(rgb, float) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def contrast(one, other) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_the_ramp_brightens_all_the_way_and_shows_on_the_dark_discs():
    colors = along_ramp(np.linspace(0, 1, 60))
    assert (np.diff([luminance(c) for c in colors]) > 0).all()
    assert min(contrast(c, (25, 29, 38)) for c in colors) > 2.5
    assert tuple(along_ramp(np.array(-3.0))) == RAMP[0]
    assert tuple(along_ramp(np.array(7.0))) == RAMP[-1]


def test_no_colouring_comes_near_the_path_or_what_is_imagined():
    for rgb in [*ACTIONS, *RAMP, UNTRIED]:
        assert np.abs(np.subtract(rgb, PATH)).max() > 90
        assert np.abs(np.subtract(rgb, IMAGINED)).max() > 60


def brightness(view, coloring, **more) -> np.ndarray:
    return np.array([luminance(c) for c in shade(view, SPEC, coloring, **more).colors])


@pytest.mark.parametrize(
    ("coloring", "told"),
    [
        (Coloring.VALUE, lambda v: v.weights.max(axis=1)),
        (Coloring.VISITS, lambda v: v.visits.sum(axis=1)),
        (Coloring.AGE, lambda v: v.born),
    ],
)
def test_more_is_brighter(coloring, told):
    view = random_view(80)
    view = replace(view, visits=view.visits + 1)
    order = np.argsort(told(view), kind="stable")
    bright = brightness(view, coloring)[order]
    assert (np.diff(bright) >= -1e-3).all()
    assert bright[-1] > 1.5 * bright[0]
    assert len(shade(view, SPEC, coloring).marks) >= 2


def test_options_that_tried_nothing_are_grey_whatever_is_asked():
    view = small_view()  # Option 3 tried nothing.
    for coloring in Coloring:
        grey = (shade(view, SPEC, coloring).colors == UNTRIED).all(axis=1)
        if coloring is Coloring.AGE:
            assert not grey.any()
        else:
            assert grey[3]


def test_one_outlier_does_not_make_all_others_look_alike():
    view = random_view(200)
    weights = view.weights.copy()
    weights[0] = 1e6
    bright = brightness(replace(view, weights=weights, visits=view.visits + 1), Coloring.VALUE)
    assert np.std(bright[1:]) > 0.1


def test_agreement_is_the_share_of_the_nearest_that_prefer_the_same():
    view = random_view(400, n_actions=3)
    shares = find_agreement(view)
    tried = view.visits.any(axis=1)
    for option in (0, 17, 399):
        gaps = view.distances_to(view.values[option])
        gaps[option] = np.inf
        gaps[~tried] = np.inf
        near = np.argsort(gaps)[:NEIGHBOURS]
        assert shares[option] == (view.best_actions[near] == view.best_actions[option]).mean()
    assert np.isnan(find_agreement(small_view())[3])
    assert np.isnan(find_agreement(random_view(1, roots=1))).all()


def test_what_is_alike_everywhere_has_one_colour_and_no_warning():
    view = replace(random_view(5), weights=np.ones((5, 2)), visits=np.ones((5, 2), np.int64))
    for coloring in Coloring:
        assert len(np.unique(shade(view, SPEC, coloring).colors, axis=0)) <= 5
    empty = random_view(0, roots=0)
    for coloring in Coloring:
        assert shade(empty, SPEC, coloring).colors.shape == (0, 3)


def test_of_too_many_options_no_agreement_is_told(monkeypatch):
    monkeypatch.setattr("ao2viz.figures.coloring.MOST_COMPARED", 20)
    assert not np.isnan(find_agreement(random_view(20))).all()
    assert np.isnan(find_agreement(random_view(21))).all()
