"""Colours that people with any colour vision can tell apart, on dark and on light."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Rgb = tuple[int, int, int]

# Okabe and Ito (2008), less the reddish purple: that hue belongs to the path alone.
ACTIONS: tuple[Rgb, ...] = (
    (86, 180, 233),  # sky blue
    (230, 159, 0),  # orange
    (0, 158, 115),  # bluish green
    (240, 228, 66),  # yellow
    (213, 94, 0),  # vermillion
    (0, 118, 184),  # blue, a little brighter than theirs to show on a dark page
)
_MIDDLE: Rgb = (216, 219, 224)  # Between sky blue and orange where actions have an order.
UNTRIED: Rgb = (104, 113, 128)
"""An option that has not tried any action prefers none."""
PATH: Rgb = (255, 74, 178)
"""The path of a decision; no colouring of options comes near this pink."""
EDGE: Rgb = (94, 105, 125)
SELECTED: Rgb = (255, 255, 255)
IMAGINED: Rgb = (190, 160, 255)
"""Where the agent expects to go; drawn dashed as well, so the hue need not be told."""
# From blue over green to yellow, ever brighter: read as light and dark it says the same.
RAMP: tuple[Rgb, ...] = (
    (64, 100, 205),
    (44, 145, 180),
    (86, 192, 132),
    (188, 220, 70),
    (242, 230, 76),
)
"""For what is more or less; its darkest end still shows on a dark page."""


@dataclass(frozen=True)
class Palette:
    """Every colour of one theme; what means the same has a like hue in all of them."""

    actions: tuple[Rgb, ...]
    middle: Rgb  # Between the first two actions where actions have an order.
    untried: Rgb
    ramp: tuple[Rgb, ...]  # From less to more; luminance goes one way all along.
    path: Rgb
    votes: tuple[Rgb, ...]  # Other voters' paths, from small shares to big ones.
    imagined: Rgb
    edge: Rgb
    selected: Rgb
    axis: Rgb
    canvas: Rgb  # Behind the forest.
    disc: Rgb  # Under each schema.
    page: Rgb  # Behind words.
    ink: Rgb
    dim: Rgb  # For words of less weight.
    chart: Rgb  # Letters on charts.
    warn: Rgb
    error: Rgb


DARK = Palette(
    actions=ACTIONS,
    middle=_MIDDLE,
    untried=UNTRIED,
    ramp=RAMP,
    path=PATH,
    votes=((174, 62, 132), (200, 64, 146), (228, 68, 160)),
    imagined=IMAGINED,
    edge=EDGE,
    selected=SELECTED,
    axis=(150, 160, 176),
    canvas=(20, 20, 20),
    disc=(25, 29, 38),
    page=(36, 36, 36),
    ink=(230, 233, 239),
    dim=(152, 162, 179),
    chart=(139, 149, 165),
    warn=(240, 180, 41),
    error=(255, 123, 114),
)
LIGHT = Palette(
    # Found by search: every two differ by 26 and more in CIELAB to every kind of colour vision,
    # each stands out from the discs by more than 3 to 1, and viser can show it (see ui/tones.py).
    actions=(
        (54, 127, 241),
        (171, 121, 0),
        (13, 75, 67),
        (87, 65, 0),
        (205, 97, 82),
        (46, 27, 223),
    ),
    middle=(118, 122, 130),
    untried=(120, 128, 141),
    ramp=((118, 136, 26), (34, 136, 104), (20, 106, 146), (40, 66, 160), (46, 16, 84)),
    path=(214, 0, 122),
    votes=((200, 84, 152), (208, 64, 150), (206, 40, 138)),
    imagined=(112, 62, 214),
    edge=(120, 129, 142),
    selected=(20, 24, 32),
    axis=(84, 92, 106),
    canvas=(255, 255, 255),
    disc=(230, 233, 238),
    page=(255, 255, 255),
    ink=(28, 34, 48),
    dim=(84, 94, 114),
    chart=(77, 86, 102),
    warn=(138, 90, 0),
    error=(179, 38, 30),
)


class Theme(Enum):
    """What the page looks like."""

    DARK = "dark"
    LIGHT = "light"

    @property
    def palette(self) -> Palette:
        """Its colours."""
        return LIGHT if self is Theme.LIGHT else DARK


def action_colors(
    n_actions: int, *, is_ordered: bool, palette: Palette = DARK
) -> NDArray[np.uint8]:
    """One colour an action, [A, 3].

    Ordered actions (a grid of torques) run from the first action's colour over grey to the
    second's, so neighbours look alike. Others get hues of their own; past the sixth they repeat,
    darkened.
    """
    if is_ordered and n_actions > 2:
        at = np.linspace(0, 2, n_actions)[:, None]
        ends = palette.actions[0], palette.middle, palette.actions[1]
        low, middle, high = (np.array(c, float) for c in ends)
        mixed = np.where(at <= 1, low + (middle - low) * at, middle + (high - middle) * (at - 1))
        return mixed.round().astype(np.uint8)
    rounds = np.arange(n_actions) // len(palette.actions)
    hues = np.array(palette.actions)[np.arange(n_actions) % len(palette.actions)]
    return (hues * (0.72**rounds)[:, None]).round().astype(np.uint8)


def along_ramp(at: NDArray[np.float64], palette: Palette = DARK) -> NDArray[np.uint8]:
    """The colours [..., 3] of the ramp at places from 0 to 1; beyond its ends, those there."""
    stops = np.linspace(0, 1, len(palette.ramp))
    channels = [np.interp(at, stops, channel) for channel in np.array(palette.ramp, float).T]
    return np.stack(channels, axis=-1).round().astype(np.uint8)


def to_css(dark: Rgb | NDArray[np.uint8], light: Rgb | NDArray[np.uint8]) -> str:
    """A colour that follows the theme of the page it stands on."""
    return f"light-dark({to_hex(light)},{to_hex(dark)})"


def to_hex(rgb: Rgb | NDArray[np.uint8]) -> str:
    """#rrggbb."""
    r, g, b = (int(v) for v in rgb)
    return f"#{r:02x}{g:02x}{b:02x}"
