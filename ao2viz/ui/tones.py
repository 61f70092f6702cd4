"""Colours that reach the eye as they were meant.

Viser's page lights every mesh and then bends its colours with the ACES film curve (Narkowicz's
and Hill's fit, as three.js has it), which turns orange into yellow. The legend would be a lie, so
what is sent to meshes is the colour that the curve will bend into the one we mean.
"""

import numpy as np
from numpy.typing import NDArray

LIGHT = 4.6
"""Intensity of the one ambient light; bright enough for the brightest colour of the palette."""

_EXPOSURE = 0.6 * np.pi  # The curve divides by 0.6, an ambient light by pi.
_INTO_CURVE = np.array(
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
)
_OUT_OF_CURVE = np.array(
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
)


def to_albedo(colors: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The colours [..., 3] to send so that these are seen; pure white comes out a little grey."""
    linear = _to_linear(np.asarray(colors, np.float64) / 255)
    bent = np.clip(linear @ np.linalg.inv(_OUT_OF_CURVE).T, 0, 0.98)
    straight = _undo_curve(bent) @ np.linalg.inv(_INTO_CURVE).T * _EXPOSURE
    return (np.clip(straight / LIGHT, 0, 1) * 255).round().astype(np.uint8)


def _to_linear(srgb: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _undo_curve(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solves y = (v (v + 0.0245786) - 0.000090537) / (v (0.983729 v + 0.432951) + 0.238081)."""
    a, b, c = 1 - 0.983729 * y, 0.0245786 - 0.432951 * y, -0.000090537 - 0.238081 * y
    return (-b + np.sqrt(b * b - 4 * a * c)) / (2 * a)
