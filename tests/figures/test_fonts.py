"""Letters that our font lacks: drawn with a font of the computer, or told by number; no boxes."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from PIL import ImageFont

from ao2viz.figures import fonts
from ao2viz.figures.drawing import Drawing, Text
from ao2viz.figures.fonts import Run, own_font, to_runs
from ao2viz.figures.raster import text_width, to_image

CACHES = (fonts._find_runs, fonts.find_font, fonts._fonts, fonts._has)


def forget() -> None:
    for cache in CACHES:
        cache.cache_clear()


def make_font(path: Path, letters: str, width: int = 1000) -> Path:
    """A font of solid bars, each letter's of another height, so that they can be told apart."""
    names = {ord(letter): f"letter{n}" for n, letter in enumerate(letters)}
    builder = FontBuilder(1000, isTTF=True)
    builder.setupGlyphOrder([".notdef", *names.values()])
    builder.setupCharacterMap(names)
    glyphs = {}
    for n, name in enumerate([".notdef", *names.values()]):
        pen = TTGlyphPen(None)
        top = 100 if n == 0 else 300 + 50 * n
        pen.moveTo((100, 0))
        for point in ((100, top), (900, top), (900, 0)):
            pen.lineTo(point)
        pen.closePath()
        glyphs[name] = pen.glyph()
    builder.setupGlyf(glyphs)
    builder.setupHorizontalMetrics(dict.fromkeys(glyphs, (width, 100)))
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupNameTable({"familyName": path.stem, "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    builder.save(path)
    return path


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The only place where this computer keeps fonts; empty."""
    monkeypatch.setattr(fonts, "font_folders", lambda: (tmp_path, tmp_path / "not there"))
    forget()
    yield tmp_path
    forget()


def picture(text: str, anchor: str = "start") -> np.ndarray:
    at = {"start": 10.0, "middle": 200.0, "end": 390.0}[anchor]
    shape = Text(at, 40, text, 20, "#000000", anchor=anchor)
    return np.asarray(to_image(Drawing(400, 60, (shape,), "", "#ffffff")))


def test_our_own_letters_take_one_font(folder: Path) -> None:
    for text in ("push left", "größer − 3.1° → Ωй", ""):
        assert to_runs(text) == ((Run(text, None),) if text else ())
    font = ImageFont.truetype(own_font(False), 100, layout_engine=ImageFont.Layout.BASIC)
    assert text_width("größer", 20) == font.getlength("größer") * 20 / 100


def test_a_font_of_the_computer_draws_what_ours_lacks(folder: Path) -> None:
    (folder / "broken.ttf").write_bytes(b"no font")
    font = make_font(folder / "NotoSansCJK-Regular.ttf", "中文左")
    forget()
    assert to_runs("push 中文!") == (Run("push ", None), Run("中文", font), Run("!", None))
    assert text_width("中文", 20) == pytest.approx(40)
    one, other, same = picture("中文"), picture("文中"), picture("中文")
    assert (one == same).all()
    assert (one != other).any()
    assert (one < 128).any(axis=(0, 2)).nonzero()[0].max() < 10 + 2 * 20
    for anchor, edge in (("start", 10), ("end", 390 - 40)):
        columns = (picture("中文", anchor) < 128).any(axis=(0, 2)).nonzero()[0]
        assert abs(columns.min() - edge) < 5


def test_without_one_letters_are_told_by_number_and_names_stay_apart(folder: Path) -> None:
    assert to_runs("推 left 中文")[0].font is None
    assert "".join(run.text for run in to_runs("推 left 中文")) == "[63A8] left [4E2D 6587]"
    assert (picture("中文") != picture("文中")).any()
    # What only joins or varies letters is left out.
    assert "".join(run.text for run in to_runs("中\ufe0f")) == "[4E2D]"


def test_words_of_a_script_keep_the_space_between_them_in_one_piece(folder: Path) -> None:
    font = make_font(folder / "a.ttf", "שלום ")
    forget()
    assert to_runs("שלום שלום x") == (Run("שלום שלום", font), Run(" x", None))


def test_nothing_is_ever_a_box(folder: Path) -> None:
    make_font(folder / "a.ttf", "中")
    forget()
    text = "中 文 한국어 ไทย العربية हिन्दी \U0001f600 x"
    for run in to_runs(text):
        path = own_font(False) if run.font is None else run.font
        assert all(fonts._has(path, letter) for letter in run.text)
