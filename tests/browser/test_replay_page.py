"""The three-dimensional replay, opened from disk with the network off."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser

from ao2viz import export
from tests.exports.agents import first_steps, hostile


def pink(screenshot: bytes) -> int:
    """How many pixels have the colour that belongs to the path alone."""
    pixels = np.asarray(Image.open(io.BytesIO(screenshot)).convert("RGB")).astype(int)
    return int((np.abs(pixels - (255, 74, 178)).max(axis=2) < 40).sum())


def test_it_plays_without_a_server(browser: Browser, tmp_path: Path, capfd) -> None:
    agent = hostile()
    short = replace(agent, episodes=(first_steps(agent.episodes[0], 8),))
    shares: list[float] = []
    path = export(short, tmp_path / "replay.html", "replay", progress=shares.append)
    assert capfd.readouterr().out == ""
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    context = browser.new_context(viewport={"width": 900, "height": 600}, offline=True)
    page = context.new_page()
    problems: list[str] = []
    requests: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
    page.on("dialog", lambda dialog: problems.append(dialog.message))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_selector("canvas")
    for _ in range(40):
        page.wait_for_timeout(500)
        if pink(page.screenshot()) > 30:
            break
    else:
        raise AssertionError("No path was ever drawn.")
    assert problems == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "blob:"))] == []
    context.close()
