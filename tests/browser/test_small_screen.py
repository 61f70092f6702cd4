"""At 1024 × 768 nothing is cut off, and whoever goes by key sees where they are."""

from tests.browser.conftest import Open

SMALL = {"width": 1024, "height": 768}
TABS = (
    *("Why", "Moments", "Branch", "Past"),
    *("Inspect", "Agent", "Forest", "Charts", "What if", "Compare", "Export"),
)
DIALOGS = ("Help", "Settings", "Library")
# What sticks out of its panel to a side, or is wider than the box that clips it.
CUT_OFF = """() => {
  const found = [];
  const words = ".mantine-Button-label, .mantine-Tabs-tabLabel, label, .ao, .ao *, .ao-legend *";
  for (const each of document.querySelectorAll(words)) {
    const box = each.getBoundingClientRect(), style = getComputedStyle(each);
    const isForEars = style.clipPath !== "none" || each.closest("svg");
    if (box.width < 2 || box.height < 2 || isForEars) continue;
    const clips = style.display !== "inline" && style.overflowX !== "visible";
    const room = each.closest("[data-scrollarea-viewport], .mantine-Modal-content");
    const [left, right] = room ? [room.getBoundingClientRect().left,
                                  room.getBoundingClientRect().right] : [0, innerWidth];
    if (box.left < left - 1 || box.right > right + 1 ||
        (clips && each.scrollWidth > each.clientWidth + 1)) {
      found.push(`${each.tagName} ${each.className}: ${each.textContent.slice(0, 60)}`);
    }
  }
  return found;
}"""
# Docks that would scroll sideways.
SIDEWAYS = """() => [...document.querySelectorAll('[data-scrollarea-viewport]')]
    .filter((area) => area.scrollWidth > area.clientWidth + 1)
    .map((area) => area.textContent.slice(0, 80))"""
FOCUS = """() => {
  const style = getComputedStyle(document.activeElement);
  const isSeen = style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 1;
  return [document.activeElement.outerHTML.slice(0, 600), isSeen];
}"""


def test_what_is_cut_off_is_found(dashboard, open_window: Open):
    window = open_window(dashboard, size=SMALL)
    window.page.evaluate(
        # Beside all that the page draws anew.
        "document.body.insertAdjacentHTML('beforeend', '<div class=\"ao\" style=\"position:fixed;"
        'top:0;left:0"><p style="width:1900px">wide</p>'
        '<p style="width:20px;overflow:hidden;white-space:nowrap">long words</p></div>\')'
    )
    found = window.page.evaluate(CUT_OFF)
    assert any(each.endswith(": wide") for each in found)
    assert any(each.endswith(": long words") for each in found)


def test_nothing_is_cut_off_on_a_small_screen(dashboard, open_window: Open):
    window = open_window(dashboard, size=SMALL, is_first_visit=True)
    window.page.locator(".ao-hint").wait_for()
    window.hold()
    window.press("Decided")
    for tab in TABS:
        window.page.get_by_role("tab", name=tab).click()
        window.page.wait_for_timeout(600)
        window.wait_for_none(lambda: window.page.evaluate(CUT_OFF), tab)
        window.wait_for_none(lambda: window.page.evaluate(SIDEWAYS), tab)
    for dialog in DIALOGS:
        window.press(dialog)
        window.page.get_by_role("dialog").wait_for()
        window.page.wait_for_timeout(600)
        window.wait_for_none(lambda: window.page.evaluate(CUT_OFF), dialog)
        window.page.keyboard.press("Escape")
        window.page.get_by_role("dialog").wait_for(state="hidden")


def test_the_control_in_focus_is_always_seen(dashboard, open_window: Open):
    window = open_window(dashboard, size=SMALL)
    window.hold()
    met = set()
    for _ in range(45):
        window.page.keyboard.press("Tab")
        control, is_seen = window.page.evaluate(FOCUS)
        assert is_seen or control.startswith("<body"), control
        met.add(control)
    assert len(met) > 30
