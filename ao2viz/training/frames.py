"""Pictures of environments, small enough to send often."""

import io
from typing import Any

import gymnasium as gym
import numpy as np
from PIL import Image

_QUALITY = 75
_MAX_SIDE = 800


def jpeg(pixels: Any) -> bytes | None:
    """A picture [height, width, 3] of uint8 as JPEG; None if it is something else."""
    if not (isinstance(pixels, np.ndarray) and pixels.ndim == 3 and pixels.shape[2] == 3):
        return None
    image = Image.fromarray(pixels.astype(np.uint8))
    if max(image.size) > _MAX_SIDE:
        image.thumbnail((_MAX_SIDE, _MAX_SIDE))
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=_QUALITY)
    return buffer.getvalue()


def draw(env: gym.Env) -> bytes | None:
    """The environment as it is now; None if it cannot draw.

    Whatever the environment raises while drawing passes through.
    """
    return jpeg(env.render()) if env.render_mode == "rgb_array" else None
