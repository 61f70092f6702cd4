"""The pictures of the guide: each can be taken anew, in both themes, and none is too big."""

import re
from pathlib import Path

from PIL import Image

from tools.pictures import IMAGES, MOST_BYTES, SCENES, SIZE

GUIDE = Path(__file__).resolve().parents[1] / "docs" / "guide.md"


def test_the_guide_shows_every_picture_that_can_be_taken_and_no_other():
    text = GUIDE.read_text("utf-8")
    assert set(re.findall(r"!\[[^\]]+\]\(images/([\w-]+)\.png\)", text)) == set(SCENES)
    pairs = re.findall(r"\]\(images/([\w-]+)\.png\)\]\(images/light/([\w-]+)\.png\)", text)
    assert [dark for dark, _ in pairs] == [light for _, light in pairs]
    assert {light for _, light in pairs} == {path.stem for path in (IMAGES / "light").glob("*")}


def test_every_picture_is_in_its_theme_and_not_too_big():
    assert {path.stem for path in IMAGES.glob("*.png")} == set(SCENES)
    for folder, is_light in ((IMAGES, False), (IMAGES / "light", True)):
        for path in folder.glob("*.png"):
            assert path.stat().st_size <= MOST_BYTES, path
            with Image.open(path) as image:
                assert image.size == (SIZE["width"], SIZE["height"]), path
                corner = image.convert("L").getpixel((SIZE["width"] - 3, SIZE["height"] - 3))
            assert (corner > 100) is is_light, path  # A dialog dims what is behind it.
