"""The page itself: its theme, its motion, its first words, and what it says without its server."""

import io
import json

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, BrowserContext

from ao2viz.figures.palette import DARK, LIGHT, Theme, to_hex
from ao2viz.training.runner import ThreadRunner
from ao2viz.ui.app import Dashboard
from tests.browser.conftest import HINT_KEY, Open, Window

# What the browser paints with, whatever the style sheet says where.
COLORS = """() => {
  const shown = (color) => {
    const probe = document.createElement("span");
    probe.style.color = color;
    document.querySelector(".ao").append(probe);
    const rgb = getComputedStyle(probe).color.match(/[0-9]+/g).slice(0, 3).map(Number);
    probe.remove();
    return "#" + rgb.map((each) => each.toString(16).padStart(2, "0")).join("");
  };
  return {
    scheme: document.documentElement.dataset.mantineColorScheme,
    ink: shown("var(--ao-ink)"),
    path: shown("var(--ao-path)"),
    words: shown(getComputedStyle(document.querySelector(".ao")).color),
  };
}"""


def context_of(browser: Browser, color_scheme, **more) -> BrowserContext:
    return browser.new_context(color_scheme=color_scheme, **more)


def wait_for_theme(window: Window, theme: Theme) -> None:
    palette = theme.palette
    expected = {
        "scheme": theme.value,
        "ink": to_hex(palette.ink),
        "path": to_hex(palette.path),
        "words": to_hex(palette.ink),
    }
    window.wait(lambda: window.page.evaluate(COLORS) == expected, f"the {theme.value} theme")


def kept(window: Window) -> dict:
    return json.loads(window.page.evaluate(f"localStorage.getItem('{HINT_KEY}')"))


def test_the_theme_follows_the_system_until_chosen_and_is_remembered(
    dashboard, open_window: Open, browser
):
    system = context_of(browser, "light")
    window = open_window(dashboard, context=system)
    window.hold()
    wait_for_theme(window, Theme.LIGHT)
    other = open_window(dashboard)
    other.hold()
    wait_for_theme(other, Theme.DARK)

    window.press("Dark")
    wait_for_theme(window, Theme.DARK)
    window.page.keyboard.press("Shift+C")
    wait_for_theme(window, Theme.LIGHT)
    window.page.keyboard.press("Shift+C")
    wait_for_theme(window, Theme.DARK)
    window.wait(lambda: kept(window).get("theme") == "dark", "the browser to keep it")
    other.press("Light")
    wait_for_theme(other, Theme.LIGHT)
    wait_for_theme(window, Theme.DARK)

    again = open_window(dashboard, context=system)
    wait_for_theme(again, Theme.DARK)
    again.page.keyboard.press("Shift+?")
    again.page.get_by_role("dialog").wait_for()
    again.wait(lambda: again.field("Theme").input_value() == "dark", "what was chosen")
    again.choose("Theme", "as the system")
    wait_for_theme(again, Theme.LIGHT)


def test_the_canvas_is_drawn_in_the_colours_of_the_theme(dashboard, open_window: Open, browser):
    window = open_window(dashboard, draws=True, context=context_of(browser, "light"))
    window.hold()
    wait_for_theme(window, Theme.LIGHT)

    window.wait(lambda: share_of(window, LIGHT.canvas) > 0.2, "a white canvas")
    window.wait(lambda: share_of(window, LIGHT.disc) > 0.02, "discs on it")
    window.press("Dark")
    window.wait(lambda: share_of(window, DARK.canvas) > 0.2, "a dark canvas")
    window.wait(lambda: share_of(window, DARK.disc) > 0.02, "discs on it")


def share_of(window: Window, rgb) -> float:
    """How much of the canvas has about this colour, as the eye sees it."""
    box = {"x": 560, "y": 20, "width": 520, "height": 760}
    with Image.open(io.BytesIO(window.page.screenshot(clip=box))) as image:
        pixels = np.asarray(image.convert("RGB"), int)
    return float((np.abs(pixels - rgb).max(axis=2) <= 6).mean())


def test_who_wants_nothing_to_move_is_met_by_a_held_page(dashboard, open_window: Open, browser):
    still = context_of(browser, "dark", reduced_motion="reduce")
    window = open_window(dashboard, context=still)
    window.wait(lambda: window.view.appearance.rests, "the wish of the system")
    assert not window.view.transport.is_playing
    assert window.view.look.is_still
    takes = "() => getComputedStyle(document.querySelector('button')).transitionDuration"
    window.wait(lambda: window.page.evaluate(takes) == "0s", "no transitions")

    other = open_window(dashboard)
    assert not other.view.look.is_still
    other.page.keyboard.press("Shift+?")
    other.page.get_by_role("dialog").wait_for()
    other.choose("Motion", "nothing glides")
    other.wait(lambda: other.view.look.is_still, "the choice")
    other.wait(lambda: other.page.evaluate(takes) == "0s", "no transitions")
    other.wait(lambda: kept(other).get("is_still") is True, "the browser to keep it")


def test_newcomers_are_met_once_and_never_again(dashboard, open_window: Open, browser):
    for way in ("key", "mouse"):
        context = context_of(browser, "dark")
        window = open_window(dashboard, context=context, is_first_visit=True)
        hint = window.page.locator(".ao-hint")
        hint.wait_for()
        assert "New here?" in hint.inner_text()
        if way == "key":
            window.page.keyboard.press("Escape")
        else:
            window.press("Got it")
        window.wait(lambda: hint.count() == 0, "the hint to go")  # noqa: B023
        window.wait(lambda: kept(window).get("hint_is_gone") is True, "the browser to keep that")  # noqa: B023
        again = open_window(dashboard, context=context, is_first_visit=True)
        again.wait(lambda: again.view.appearance.is_known, "what the browser remembers")  # noqa: B023
        again.page.wait_for_timeout(300)
        assert again.page.locator(".ao-hint").count() == 0


def test_a_page_without_its_server_says_so_and_comes_back_by_itself(
    shipped, tmp_path, browser: Browser
):
    def make(port: int) -> Dashboard:
        return Dashboard(port=port, shipped=shipped, folder=tmp_path, make_runner=ThreadRunner)

    first = make(0)
    first.start()
    page = browser.new_page(color_scheme="dark")
    page.goto(first.address)
    page.get_by_role("button", name="Start", exact=True).wait_for()
    window = Window(page, first, -1)
    told = page.locator(".ao-offline")
    assert not told.is_visible()
    port = first.port
    first.stop()
    told.wait_for(state="visible")
    assert "does not answer" in told.inner_text()
    assert "connects by itself" in told.inner_text()
    box = told.bounding_box()
    assert box is not None
    assert box["width"] > 300  # In the middle of the page, not squeezed into a dock.
    second = make(port)
    second.start()
    try:
        assert second.port == port
        told.wait_for(state="hidden")
        window.wait(lambda: len(second.views) == 1, "the page to be known anew")
        page.get_by_role("button", name="Play", exact=True).or_(
            page.get_by_role("button", name="Hold", exact=True)
        ).first.click()
        view = lambda: next(iter(second.views.values()))  # noqa: E731
        window.wait(lambda: view().forest is not None, "the forest to be there again")
    finally:
        page.close()
        second.stop()
