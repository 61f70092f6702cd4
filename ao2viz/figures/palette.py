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


def to_hex(rgb: Rgb | NDArray[np.uint8]) -> str:
    """#rrggbb."""
    r, g, b = (int(v) for v in rgb)
    return f"#{r:02x}{g:02x}{b:02x}"
