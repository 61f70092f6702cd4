"""Exports that a browser opens, of an agent whose every name is an attack: nothing of them runs."""

from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from ao2viz import AO2, export
from tests.browser.offline import opened, wait_for_path
from tests.exports.agents import WORST_ACTIONS, worst

STEP = 2


@pytest.mark.parametrize("format", ["html", "replay", "svg", "path-svg"])
def test_no_name_runs_anything(browser: Browser, tmp_path: Path, format: str) -> None:
    AO2.from_saved(worst()).save(tmp_path / "stranger.ao2")
    is_picture = format.endswith("svg")
    path = tmp_path / ("out.svg" if is_picture else "out.html")
    export(tmp_path / "stranger.ao2", path, format, step=STEP if is_picture else None)
    with opened(browser, path) as page:
        wait_until_shown(page, format)
        assert page.evaluate("window.ran === undefined")


def wait_until_shown(page: Page, format: str) -> None:
    """Until the names stand on the page."""
    name = WORST_ACTIONS[worst().episodes[0].decisions[STEP].action]
    if format == "html":
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowRight")
        expect(page.locator("#headline")).to_have_text(name)
    elif format == "replay":  # In its canvas there are no words to look for.
        wait_for_path(page)
    else:
        expect(page.locator("text", has_text=name[:30]).first).to_be_visible()
