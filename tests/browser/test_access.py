"""Every tab and every dialog before axe-core, in both themes: nothing serious, nothing critical."""

import pytest
from axe_playwright_python.sync_playwright import Axe

from ao2viz.ui.dialog_commands import Dialog
from tests.browser.conftest import Open, Window

TABS = (
    "Moments",
    "Branch",
    "Past",
    "Why",
    "Agent",
    "Forest",
    "Charts",
    "What if",
    "Compare",
    "Export",
)
DIALOGS = {"Shift+?": Dialog.HELP, "Shift+S": Dialog.SETTINGS, "Shift+L": Dialog.LIBRARY}


def problems(window: Window) -> list[str]:
    """What axe-core finds that keeps people out; nothing on the page is left out."""
    found = Axe().run(window.page, options={"resultTypes": ["violations"]}).response
    return [
        f"{problem['id']}: {node['html'][:200]} ({node['target']})"
        for problem in found["violations"]
        if problem["impact"] in ("serious", "critical")
        for node in problem["nodes"]
    ]


def settle(window: Window) -> None:
    """Waits until what has just been drawn has its names; see static/page.js."""
    window.page.wait_for_timeout(500)


def test_axe_finds_what_is_wrong(dashboard, open_window: Open):
    window = open_window(dashboard)
    # Beside all that the page draws anew.
    window.page.evaluate(
        "document.body.insertAdjacentHTML('beforeend', '<p style=\"position:fixed;top:0;left:0;"
        "z-index:9999;color:#777;background:#888\">faint</p>')"
    )
    found = problems(window)
    assert any(problem.startswith("color-contrast") and "faint" in problem for problem in found)


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_nothing_keeps_people_out_of_any_tab(dashboard, open_window: Open, browser, theme):
    context = browser.new_context(color_scheme=theme)
    window = open_window(dashboard, context=context, is_first_visit=True)
    window.page.locator(".ao-hint").wait_for()
    window.hold()
    window.press("Decided")
    settle(window)
    window.wait_for_none(lambda: problems(window))
    for tab in TABS:
        window.page.get_by_role("tab", name=tab).click()
        if tab == "Charts":
            window.page.locator(".js-plotly-plot").first.wait_for()
        if tab == "Agent":
            window.press("Look at the whole agent")
            window.wait_for_text("WHICH OPTIONS CARRY THE RETURN", 120)
        settle(window)
        window.wait_for_none(lambda: problems(window), tab)


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_nothing_keeps_people_out_of_any_dialog(dashboard, open_window: Open, browser, theme):
    window = open_window(dashboard, context=browser.new_context(color_scheme=theme))
    for key, dialog in DIALOGS.items():
        window.page.keyboard.press(key)
        window.wait(lambda: window.view.dialog is dialog, dialog.value)  # noqa: B023
        window.page.get_by_role("dialog").wait_for()
        settle(window)
        window.wait_for_none(lambda: problems(window), dialog.value)
        window.page.keyboard.press("Escape")
        window.wait(lambda: window.page.get_by_role("dialog").count() == 0, "it to close")
