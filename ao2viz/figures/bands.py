"""The band around a learning curve."""

from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from ao2viz.figures.palette import Rgb

_OPACITY = 0.16


def band(
    steps: NDArray[Any], low: NDArray[Any], high: NDArray[Any], color: Rgb, **more: Any
) -> go.Scatter:
    """What lies between two curves [C], lightly; `more` is what else plotly is to know."""
    r, g, b = color
    return go.Scatter(
        x=np.concatenate([steps, steps[::-1]]),
        y=np.concatenate([high, low[::-1]]),
        fill="toself",
        fillcolor=f"rgba({r},{g},{b},{_OPACITY})",
        line={"width": 0},
        mode="lines",
        hoverinfo="skip",
        showlegend=False,
        **more,
    )
