"""Which font has which letter: ours, else one of this computer's, else its number is written."""

import functools
import itertools
import os
import sys
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from PIL import Image, ImageDraw, ImageFont, features

from ao2viz.resources import static

_PROBE = 24  # Pixels; only to see whether a letter has a shape of its own.
_SUFFIXES = {".ttf", ".otf", ".ttc"}
# Fonts that hold whole scripts come first, by what their file names contain.
_BROAD = ("sanscjk", "sourcehan", "wqy", "droidsansfallback", "pingfang", "hiragino", "msyh",
          "malgun", "meiryo", "notosans", "arialuni", "unifont", "sans")  # fmt: skip


class Run(NamedTuple):
    """Letters beside one another that one font has."""

    text: str
    font: Path | None  # None: ours.


def to_runs(text: str, *, is_bold: bool = False) -> tuple[Run, ...]:
    """The text in pieces that fonts have, in order; letters that none has as [their numbers]."""
    if text.isascii():
        return (Run(text, None),) if text else ()
    return _find_runs(text, is_bold)


@functools.lru_cache(maxsize=2048)
def _find_runs(text: str, is_bold: bool) -> tuple[Run, ...]:
    found: list[tuple[str, Path | None]] = []
    for is_unknown, letters in itertools.groupby(
        text, lambda c: not _has(own_font(is_bold), c) and find_font(c) is None
    ):
        if not is_unknown:
            found += [(c, None if _has(own_font(is_bold), c) else find_font(c)) for c in letters]
            continue
        # What joins or varies letters has no shape, and says nothing beside a number.
        numbers = [f"{ord(c):04X}" for c in letters if unicodedata.category(c) not in ("Cf", "Mn")]
        if numbers:
            found += [(c, None) for c in f"[{' '.join(numbers)}]"]
    joined = _join_words(found)
    return tuple(
        Run("".join(c for c, _ in run), font)
        for font, run in itertools.groupby(joined, lambda piece: piece[1])
    )


def _join_words(found: list[tuple[str, Path | None]]) -> Iterator[tuple[str, Path | None]]:
    """Gives spaces and signs between words of one font to it: they may run from right to left."""
    last: Path | None = None
    for n, (letter, font) in enumerate(found):
        if font is None and last is not None and not letter.isalnum():
            rest = (f for c, f in found[n + 1 :] if f is not None or c.isalnum())
            if next(rest, None) == last and _has(last, letter):
                yield letter, last
                continue
        last = font
        yield letter, font


def own_font(is_bold: bool) -> Path:
    """The file of our own font."""
    return static() / "fonts" / ("DejaVuSans-Bold.ttf" if is_bold else "DejaVuSans.ttf")


@functools.cache
def open_font(path: Path, size: int) -> ImageFont.FreeTypeFont:
    """A font at a size in pixels; where Pillow can, one of the computer's joins its letters."""
    is_shaped = path.parent != static() / "fonts" and features.check("raqm")
    layout = ImageFont.Layout.RAQM if is_shaped else ImageFont.Layout.BASIC
    return ImageFont.truetype(path, size, layout_engine=layout)


@functools.cache
def find_font(letter: str) -> Path | None:
    """The first font of this computer that has a letter; None if none has."""
    return next((path for path in _fonts() if _has(path, letter)), None)


@functools.cache
def _fonts() -> tuple[Path, ...]:
    """Every font file of this computer, those that hold whole scripts first."""
    found = [
        path
        for folder in font_folders()
        if folder.is_dir()
        for path in folder.rglob("*")
        if path.suffix.lower() in _SUFFIXES
    ]

    def rank(path: Path) -> tuple[int, int, str]:
        name = path.stem.lower()
        kind = next((n for n, part in enumerate(_BROAD) if part in name), len(_BROAD))
        return kind, len(name), str(path)

    return tuple(sorted(found, key=rank))


def font_folders() -> tuple[Path, ...]:
    """Where this computer keeps its fonts."""
    home = Path.home()
    if sys.platform == "darwin":
        return Path("/System/Library/Fonts"), Path("/Library/Fonts"), home / "Library/Fonts"
    if sys.platform == "win32":
        return (Path(os.environ.get("WINDIR", "C:/Windows")) / "Fonts",)
    shared = (Path("/usr/share/fonts"), Path("/usr/local/share/fonts"))
    return *shared, home / ".local/share/fonts", home / ".fonts"


@functools.lru_cache(maxsize=8192)
def _has(path: Path, letter: str) -> bool:
    """Whether a font has a shape for a letter; what it shows for one that cannot be is none."""
    if letter.isspace():
        return True
    try:
        shape, none = (_shape(path, c) for c in (letter, "\uffff"))
    except (OSError, ValueError):  # Not a font after all, or one of pictures of another size.
        return False
    return shape != none


def _shape(path: Path, letter: str) -> bytes:
    board = Image.new("L", (3 * _PROBE, 3 * _PROBE))
    ImageDraw.Draw(board).text((_PROBE, _PROBE), letter, 255, _probe(path))
    return board.tobytes()


@functools.cache
def _probe(path: Path) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(path, _PROBE, layout_engine=ImageFont.Layout.BASIC)
