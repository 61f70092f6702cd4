"""Exported files as people open them: from disk, in a browser that has no network."""

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, Page


@contextlib.contextmanager
def opened(browser: Browser, path: Path) -> Iterator[Page]:
    """A page on a file; in the end nothing has gone wrong in it, and it has asked for nothing."""
    context = browser.new_context(viewport={"width": 900, "height": 600}, offline=True)
    page = context.new_page()
    problems: list[str] = []
    requests: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
    page.on("dialog", lambda dialog: problems.append(dialog.message))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.as_uri())
    yield page
    assert problems == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "blob:"))] == []
    context.close()


def wait_for_path(page: Page) -> None:
    """Waits until the three-dimensional replay draws a path: nothing else has its colour."""
    page.wait_for_selector("canvas")
    for _ in range(40):
        pixels = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)
        if (np.abs(pixels - (255, 74, 178)).max(axis=2) < 40).sum() > 30:
            return
        page.wait_for_timeout(500)
    raise AssertionError("No path was ever drawn.")
