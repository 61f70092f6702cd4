"""Pictures that need no browser: a few kinds of shapes, written as SVG here and as PNG beside.

Coordinates are pixels, x to the right and y down.
"""

import html
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.figures.palette import to_hex

FONT = "DejaVu Sans, Verdana, sans-serif"
"""Widths are measured with the DejaVu Sans that we ship; Verdana is as wide."""


@dataclass(frozen=True)
class Theme:
    """The colours of what has none of its own; anything that CSS takes."""

    paper: str
    ink: str
    dim: str
    edge: str
    path: str


LIGHT = Theme(paper="#ffffff", ink="#1b2230", dim="#5d6878", edge="#b9c2cf", path="#d81b84")
"""For pages and papers."""


@dataclass(frozen=True, eq=False)
class Dots:
    """Filled circles."""

    centres: NDArray[np.float64]  # [N, 2]
    radii: NDArray[np.float64]  # [N]
    colors: NDArray[np.uint8]  # [N, 3]


@dataclass(frozen=True, eq=False)
class Ring:
    """A circle's outline."""

    centre: tuple[float, float]
    radius: float
    color: str
    width: float


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight lines, each on its own."""

    ends: NDArray[np.float64]  # [E, 2, 2]
    color: str
    width: float
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class Polyline:
    """A line through points; NaN interrupts it."""

    points: NDArray[np.float64]  # [N, 2]
    color: str
    width: float
    opacity: float = 1.0


@dataclass(frozen=True)
class Box:
    """A filled rectangle with round corners."""

    x: float
    y: float
    width: float
    height: float
    color: str
    radius: float = 0.0
    outline: str = ""  # Empty: none.


@dataclass(frozen=True)
class Text:
    """One line of text; y is its base line."""

    x: float
    y: float
    text: str
    size: float
    color: str
    is_bold: bool = False
    anchor: str = "start"  # As in SVG: start, middle, end.


Shape = Dots | Ring | Segments | Polyline | Box | Text


@dataclass(frozen=True)
class Drawing:
    """Shapes from back to front."""

    width: float
    height: float
    shapes: tuple[Shape, ...]
    title: str  # What the picture shows, for those who cannot see it.
    paper: str  # "none" for what is drawn on something.


def to_svg(drawing: Drawing, *, is_inline: bool = False) -> str:
    """A stand-alone SVG document, or an element for a page.

    Texts are escaped, nothing is fetched, and nothing needs a style sheet.
    """
    size = f'width="{drawing.width:g}" height="{drawing.height:g}"'
    box = f'viewBox="0 0 {drawing.width:g} {drawing.height:g}"'
    head = "" if is_inline else '<?xml version="1.0" encoding="UTF-8"?>\n'
    space = "" if is_inline else 'xmlns="http://www.w3.org/2000/svg" '
    title = html.escape(drawing.title)
    parts = [
        f'{head}<svg {space}{box} {"" if is_inline else size} role="img" '
        f'font-family="{FONT}"><title>{title}</title>'
    ]
    if drawing.paper != "none":
        parts.append(f'<rect width="100%" height="100%" fill="{drawing.paper}"/>')
    parts += [_element(shape) for shape in drawing.shapes]
    return "\n".join([*parts, "</svg>"])


def _element(shape: Shape) -> str:
    match shape:
        case Dots():
            return _dots(shape)
        case Ring():
            x, y = shape.centre
            return (
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{shape.radius:.1f}" fill="none" '
                f'stroke="{shape.color}" stroke-width="{shape.width:g}"/>'
            )
        case Segments():
            lines = "".join(
                f"M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}"
                for (x1, y1), (x2, y2) in shape.ends.tolist()
            )
            return _stroke(lines, shape.color, shape.width, shape.opacity)
        case Polyline():
            return _stroke(_trace(shape.points), shape.color, shape.width, shape.opacity)
        case Box():
            outline = f' stroke="{shape.outline}"' if shape.outline else ""
            return (
                f'<rect x="{shape.x:.1f}" y="{shape.y:.1f}" width="{shape.width:.1f}" '
                f'height="{shape.height:.1f}" rx="{shape.radius:g}" fill="{shape.color}"{outline}/>'
            )
        case Text():
            weight = ' font-weight="bold"' if shape.is_bold else ""
            return (
                f'<text x="{shape.x:.1f}" y="{shape.y:.1f}" font-size="{shape.size:g}" '
                f'text-anchor="{shape.anchor}" fill="{shape.color}"{weight}>'
                f"{html.escape(shape.text)}</text>"
            )


def _dots(dots: Dots) -> str:
    """One group for each colour: the same picture in a fraction of the bytes."""
    groups = []
    colors, group_of = np.unique(dots.colors, axis=0, return_inverse=True)
    for i, color in enumerate(colors):
        rows = np.flatnonzero(group_of.reshape(-1) == i)
        circles = "".join(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}"/>'
            for (x, y), r in zip(
                dots.centres[rows].tolist(), dots.radii[rows].tolist(), strict=True
            )
        )
        groups.append(f'<g fill="{to_hex(color)}">{circles}</g>')
    return "".join(groups)


def _stroke(path: str, color: str, width: float, opacity: float) -> str:
    faint = "" if opacity == 1 else f' stroke-opacity="{opacity:g}"'
    return (
        f'<path d="{path}" fill="none" stroke="{color}" stroke-width="{width:g}" '
        f'stroke-linejoin="round" stroke-linecap="round"{faint}/>'
    )


def _trace(points: NDArray[np.float64]) -> str:
    parts, is_drawing = [], False
    for x, y in points.tolist():
        if not (np.isfinite(x) and np.isfinite(y)):
            is_drawing = False
            continue
        parts.append(f"{'L' if is_drawing else 'M'}{x:.1f} {y:.1f}")
        is_drawing = True
    return "".join(parts)
