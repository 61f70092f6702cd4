"""Colours that people with any colour vision can tell apart, on dark and on light."""

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
    (0, 114, 178),  # blue
)
_MIDDLE: Rgb = (216, 219, 224)  # Between sky blue and orange where actions have an order.
UNTRIED: Rgb = (92, 101, 114)
"""An option that has not tried any action prefers none."""
PATH: Rgb = (255, 74, 178)
"""The path of a decision; no colouring of options comes near this pink."""
EDGE: Rgb = (70, 80, 98)
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


def action_colors(n_actions: int, *, is_ordered: bool) -> NDArray[np.uint8]:
    """One colour an action, [A, 3].

    Ordered actions (a grid of torques) run from sky blue over grey to orange, so neighbours look
    alike. Others get hues of their own; past the sixth they repeat, darkened.
    """
    if is_ordered and n_actions > 2:
        at = np.linspace(0, 2, n_actions)[:, None]
        low, middle, high = (np.array(c, float) for c in (ACTIONS[0], _MIDDLE, ACTIONS[1]))
        mixed = np.where(at <= 1, low + (middle - low) * at, middle + (high - middle) * (at - 1))
        return mixed.round().astype(np.uint8)
    rounds = np.arange(n_actions) // len(ACTIONS)
    hues = np.array(ACTIONS)[np.arange(n_actions) % len(ACTIONS)]
    return (hues * (0.72**rounds)[:, None]).round().astype(np.uint8)


def along_ramp(at: NDArray[np.float64]) -> NDArray[np.uint8]:
    """The colours [..., 3] of RAMP at places from 0 to 1; beyond the ends, those of the ends."""
    stops = np.linspace(0, 1, len(RAMP))
    channels = [np.interp(at, stops, channel) for channel in np.array(RAMP, float).T]
    return np.stack(channels, axis=-1).round().astype(np.uint8)


def to_hex(rgb: Rgb | NDArray[np.uint8]) -> str:
    """#rrggbb."""
    r, g, b = (int(v) for v in rgb)
    return f"#{r:02x}{g:02x}{b:02x}"
