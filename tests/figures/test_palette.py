"""Both themes measured: what is read, what is seen, and what every eye can tell apart."""

from itertools import combinations, pairwise

import numpy as np
import pytest

from ao2viz.figures.palette import DARK, LIGHT, Palette, action_colors, along_ramp, to_css

THEMES = pytest.mark.parametrize("palette", [DARK, LIGHT], ids=["dark", "light"])
# Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB.
EYES = {
    "usual": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "tritanopia": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}


def to_linear(rgb) -> np.ndarray:
    srgb = np.asarray(rgb, float) / 255
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def contrast(one, other) -> float:
    """As WCAG 2.2 defines it."""
    low, high = sorted(float(to_linear(c) @ (0.2126, 0.7152, 0.0722)) for c in (one, other))
    return (high + 0.05) / (low + 0.05)


def to_lab(linear) -> np.ndarray:
    """CIELAB of linear RGB under D65."""
    to_xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    xyz = np.clip(linear, 0, 1) @ to_xyz.T / (0.9505, 1.0, 1.089)
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def difference(one, other, eye) -> float:
    """How far apart in CIELAB two colours look to an eye; about 2 is the least that is seen."""
    first, second = (to_lab(eye @ to_linear(color)) for color in (one, other))
    return float(np.linalg.norm(first - second))


def test_the_measures_give_the_known_values():
    assert contrast((255, 255, 255), (0, 0, 0)) == pytest.approx(21)
    assert contrast((119, 119, 119), (255, 255, 255)) == pytest.approx(4.48, abs=0.01)
    red, green = (200, 60, 40), (120, 110, 30)
    assert difference(red, green, EYES["usual"]) > 3 * difference(red, green, EYES["deuteranopia"])


@THEMES
def test_words_are_read_on_the_page_and_on_the_canvas(palette: Palette):
    for words in (palette.ink, palette.dim, palette.chart, palette.warn, palette.error):
        assert contrast(words, palette.page) >= 4.5
        assert contrast(words, palette.canvas) >= 4.5
    assert contrast(palette.page, palette.warn) >= 4.5  # The letters of a mark.


@THEMES
def test_whatever_is_drawn_shows_on_the_canvas_the_discs_and_the_page(palette: Palette):
    drawn = {
        **{f"action {i}": color for i, color in enumerate(palette.actions)},
        **{
            f"ramp {i}": color for i, color in enumerate(along_ramp(np.linspace(0, 1, 30), palette))
        },
        **{f"votes {i}": color for i, color in enumerate(palette.votes)},
        **{f"torque {i}": color for i, color in enumerate(ordered(palette))},
        "untried": palette.untried,
        "path": palette.path,
        "imagined": palette.imagined,
        "edge": palette.edge,
        "selected": palette.selected,
        "axis": palette.axis,
    }
    for ground in (palette.canvas, palette.disc):
        faint = {name: contrast(color, ground) for name, color in drawn.items()}
        assert {name: told for name, told in faint.items() if told < 3} == {}
    # Swatches, bars and lines on the page; edges are drawn on the canvas alone.
    for name in [f"action {i}" for i in range(len(palette.actions))] + [
        "path",
        "imagined",
        "untried",
    ]:
        assert contrast(drawn[name], palette.page) >= 3, name


def ordered(palette: Palette) -> np.ndarray:
    return action_colors(5, is_ordered=True, palette=palette)


@THEMES
@pytest.mark.parametrize("eye", EYES.values(), ids=EYES)
def test_every_eye_tells_the_actions_and_the_untried_apart(palette: Palette, eye):
    for one, other in combinations([*palette.actions, palette.untried], 2):
        assert difference(one, other, eye) > 14, (one, other)


@THEMES
@pytest.mark.parametrize("eye", EYES.values(), ids=EYES)
def test_neighbouring_torques_and_steps_of_the_ramp_look_alike_but_not_the_same(palette, eye):
    for colors in (ordered(palette), np.array(palette.ramp)):
        for one, other in pairwise(colors):
            assert difference(one, other, eye) > 6


@THEMES
def test_the_ramp_goes_one_way_from_dark_to_bright_or_back(palette: Palette):
    shown = along_ramp(np.linspace(0, 1, 60), palette)
    ways = np.sign(np.diff([contrast(color, (0, 0, 0)) for color in shown]))
    assert set(ways) == {1.0 if palette is DARK else -1.0}


@THEMES
def test_no_colouring_comes_near_the_path_or_what_is_imagined(palette: Palette):
    for rgb in [*palette.actions, *palette.ramp, palette.untried, palette.edge]:
        assert np.abs(np.subtract(rgb, palette.path)).max() > 80
        assert np.abs(np.subtract(rgb, palette.imagined)).max() > 60


def test_a_colour_of_the_page_follows_its_theme():
    assert to_css(DARK.path, LIGHT.path) == "light-dark(#d6007a,#ff4ab2)"
