"""The page as a file: small enough, self-contained, and sound."""

import re
from html.parser import HTMLParser

import pytest

from ao2viz.exports import report
from ao2viz.store.saved import SavedAgent
from tests.exports.conftest import Export


class _Reader(HTMLParser):
    """Collects what a page would load, and what could run."""

    def __init__(self) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.handlers: list[str] = []
        self.styles: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in {"src", "href", "xlink:href", "action", "data", "poster"}:
                self.loads.append(value or "")
            if name.startswith("on"):
                self.handlers.append(f"{tag} {name}")
            if name == "style":
                self.styles.append(f"{tag} {value}")


@pytest.mark.parametrize("name", ["cartpole", "pendulum", "hostile"])
def test_a_page_loads_nothing(name: str, request: pytest.FixtureRequest, write: Export) -> None:
    page = write(request.getfixturevalue(name), "html").read_text("utf-8")
    reader = _Reader()
    reader.feed(page)
    assert reader.loads == ["#steps"]
    assert reader.handlers == []
    assert reader.styles == []  # The policy would refuse them.
    assert "@import" not in page
    assert "url(" not in page.split("</style>")[0]
    assert page.count("<script") == 2


def test_a_page_too_big_for_a_browser_is_refused_in_words(
    cartpole: SavedAgent, write: Export, monkeypatch: pytest.MonkeyPatch, tmp_path
) -> None:
    monkeypatch.setattr(report, "MAX_BYTES", 100_000)
    with pytest.raises(ValueError, match=r"40 steps\. Choose a shorter episode") as error:
        write(cartpole, "html")
    assert "\n" not in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_a_page_has_the_same_bytes_every_time(cartpole: SavedAgent, write: Export) -> None:
    first = write(cartpole, "html").read_bytes()
    assert write(cartpole, "html", overwrite=True).read_bytes() == first
    assert re.search(rb"sha256-[A-Za-z0-9+/]{43}=", first)
