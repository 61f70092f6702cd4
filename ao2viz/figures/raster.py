"""Drawings as pixels, through Pillow: no browser; fonts of the system only for far scripts."""

from typing import IO

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageColor, ImageDraw, ImageFont

from ao2viz.figures.drawing import Box, Dots, Drawing, Polyline, Ring, Segments, Shape, Text
from ao2viz.figures.fonts import Run, open_font, own_font, to_runs

_FINER = 3  # Drawn so many times larger and shrunk, which smooths the edges.


def to_image(drawing: Drawing, scale: float = 1.0) -> Image.Image:
    """The drawing in RGB, `scale` pixels to a unit; "none" as paper becomes white."""
    width, height = round(drawing.width * scale), round(drawing.height * scale)
    fine = scale * _FINER
    paper = "#ffffff" if drawing.paper == "none" else drawing.paper
    board = Image.new("RGB", (width * _FINER, height * _FINER), paper)
    pen = ImageDraw.Draw(board, "RGBA")
    for shape in drawing.shapes:
        _draw(pen, shape, fine)
    return board.resize((width, height), Image.Resampling.BOX)


def write_png(drawing: Drawing, stream: IO[bytes], scale: float = 2.0) -> None:
    """Writes the drawing as PNG."""
    to_image(drawing, scale).save(stream, "PNG")


def text_width(text: str, size: float, *, is_bold: bool = False) -> float:
    """How wide a text is, in the units of `size`."""
    runs = to_runs(text, is_bold=is_bold)
    return sum(_font(run, 100, is_bold).getlength(run.text) for run in runs) * size / 100


def wrap(text: str, size: float, width: float) -> list[str]:
    """The text in lines that are no wider, broken at spaces, or within words that are too long."""
    lines, line = [], ""
    waiting = text.split()[::-1]
    while waiting:
        word = waiting.pop()
        longer = f"{line} {word}" if line else word
        if text_width(longer, size) <= width:
            line = longer
        elif line:
            lines.append(line)
            line = ""
            waiting.append(word)
        else:
            keep = next((n for n in range(len(word), 1, -1) if _fits(word[:n], size, width)), 1)
            lines.append(word[:keep])
            waiting += [word[keep:]] if word[keep:] else []
    return [*lines, line] if line else lines


def shorten(text: str, size: float, width: float) -> str:
    """The text, its end cut off where it is too wide."""
    if text_width(text, size) <= width:
        return text
    while text and text_width(f"{text}…", size) > width:
        text = text[:-1]
    return f"{text}…"


def _fits(text: str, size: float, width: float) -> bool:
    return text_width(text, size) <= width


def _font(run: Run, size: int, is_bold: bool) -> ImageFont.FreeTypeFont:
    return open_font(own_font(is_bold) if run.font is None else run.font, size)


def _color(color: str, opacity: float = 1.0) -> tuple[int, ...]:
    return (*ImageColor.getrgb(color)[:3], round(255 * opacity))


def _draw(pen: ImageDraw.ImageDraw, shape: Shape, k: float) -> None:
    """Draws a shape, k pixels to a unit."""
    match shape:
        case Dots():
            rows = zip(
                (shape.centres * k).tolist(),
                (shape.radii * k).tolist(),
                shape.colors.tolist(),
                strict=True,
            )
            for (x, y), r, color in rows:
                pen.ellipse((x - r, y - r, x + r, y + r), fill=tuple(color))
        case Ring():
            (x, y), r = shape.centre, shape.radius + shape.width / 2
            pen.ellipse(
                ((x - r) * k, (y - r) * k, (x + r) * k, (y + r) * k),
                outline=_color(shape.color),
                width=max(1, round(shape.width * k)),
            )
        case Segments():
            color, width = _color(shape.color, shape.opacity), max(1, round(shape.width * k))
            for one, other in (shape.ends * k).tolist():
                pen.line((*one, *other), fill=color, width=width)
        case Polyline():
            color, width = _color(shape.color, shape.opacity), max(1, round(shape.width * k))
            for piece in _pieces(shape.points * k):
                pen.line([tuple(point) for point in piece.tolist()], color, width, "curve")
        case Box():
            pen.rounded_rectangle(
                (
                    shape.x * k,
                    shape.y * k,
                    (shape.x + shape.width) * k,
                    (shape.y + shape.height) * k,
                ),
                shape.radius * k,
                _color(shape.color),
                _color(shape.outline) if shape.outline else None,
                max(1, round(k)) if shape.outline else 0,
            )
        case Text():
            _write(pen, shape, k)


def _write(pen: ImageDraw.ImageDraw, text: Text, k: float) -> None:
    """Draws a text, piece by piece where it takes several fonts."""
    size, x = round(text.size * k), text.x * k
    runs = to_runs(text.text, is_bold=text.is_bold)
    anchor = {"start": "ls", "middle": "ms", "end": "rs"}[text.anchor]
    if len(runs) > 1:
        widths = [_font(run, size, text.is_bold).getlength(run.text) for run in runs]
        x -= {"start": 0.0, "middle": 0.5, "end": 1.0}[text.anchor] * sum(widths)
        anchor = "ls"
    for run in runs:
        font = _font(run, size, text.is_bold)
        pen.text((x, text.y * k), run.text, _color(text.color), font, anchor)
        x += font.getlength(run.text)


def _pieces(points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """The parts of a line between its interruptions, of at least two points."""
    known = np.isfinite(points).all(axis=1)
    borders = np.flatnonzero(np.diff(np.r_[False, known, False].astype(np.int8)))
    pairs = borders.reshape(-1, 2).tolist()
    return [points[first:last] for first, last in pairs if last - first > 1]
