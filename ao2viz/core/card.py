"""Facts as a small piece of HTML, for notebooks: escaped, complete in itself, and light."""

import html
import math
from collections.abc import Iterable, Sequence

_WIDTH, _HEIGHT = 320, 48
_MOST_POINTS = 400


def make_card(
    title: str, facts: Iterable[tuple[str, str]], line: Sequence[float] = (), told: str = ""
) -> str:
    """A title and a table of facts; below it a line through numbers, which `told` explains.

    Whatever the texts are, they are shown as they are.
    """
    rows = "".join(
        f"<tr><th style='text-align:left'>{_escape(name)}</th>"
        f"<td style='text-align:left'>{_escape(value)}</td></tr>"
        for name, value in facts
    )
    drawn = _draw(line, told)
    return f"<div><b>{_escape(title)}</b><table>{rows}</table>{drawn}</div>"


def _draw(line: Sequence[float], told: str) -> str:
    finite = [value for value in line if math.isfinite(value)]
    if len(finite) < 2:
        return ""
    step = max(1, len(finite) // _MOST_POINTS)
    shown = finite[::step]
    low, high = min(shown), max(shown)
    scale = _HEIGHT / (high - low) if high > low else 0.0
    points = " ".join(
        f"{_WIDTH * i / max(1, len(shown) - 1):.1f},{_HEIGHT - (value - low) * scale:.1f}"
        for i, value in enumerate(shown)
    )
    return (
        f"<svg viewBox='-2 -2 {_WIDTH + 4} {_HEIGHT + 4}' width='{_WIDTH}' height='{_HEIGHT}' "
        f"role='img'><title>{_escape(told)}</title><polyline points='{points}' fill='none' "
        f"stroke='currentColor' stroke-width='1.5'/></svg><div><small>{_escape(told)}: "
        f"{low:.6g} to {high:.6g}</small></div>"
    )


def _escape(text: str) -> str:
    return html.escape(text, quote=True)
