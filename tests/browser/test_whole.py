"""The agent as a whole: opened by key, read, and from each fact a click to its place."""

import re

from tests.browser.conftest import Open, Window


def open_tab(window: Window) -> None:
    window.hold()
    window.page.keyboard.press("Shift+W")
    window.wait_for_text("WHICH OPTIONS CARRY THE RETURN", 120)


def button(window: Window, words: str):
    """The first button of the panel whose words begin so."""
    found = window.page.get_by_role("button", name=re.compile(f"^{words}")).first
    found.scroll_into_view_if_needed()
    return found


def test_it_is_read_and_leads_to_moments_and_options(dashboard, open_window: Open):
    window = open_window(dashboard)
    open_tab(window)
    tab = window.page.get_by_role("tab", name="Agent")
    assert tab.get_attribute("aria-selected") == "true"
    rows = window.page.locator(".ao-shares tr")
    names = {feature.name for feature in window.view.spec.features}
    assert {rows.nth(n).locator("td").first.inner_text() for n in range(1, 5)} == names
    shares = [int(rows.nth(n).locator("td").nth(1).inner_text().split()[0]) for n in range(1, 5)]
    assert shares == sorted(shares, reverse=True)
    assert 98 <= sum(shares) <= 102
    moment = button(window, r"Episode \d+, step \d+: .* at stake")
    episode, step = map(int, re.findall(r"\d+", moment.inner_text())[:2])
    moment.click()
    window.wait(lambda: window.view.transport.position == step, "the moment")
    assert window.view.episode_index == episode - 1
    farthest = button(window, "Farthest: episode")
    episode, step = map(int, re.findall(r"\d+", farthest.inner_text())[:2])
    farthest.click()
    window.wait(lambda: window.view.transport.position == step, "the farthest state")
    assert window.view.episode_index == episode - 1
    option = button(window, r"Option \d+: .* of the states")
    chosen = int(re.findall(r"\d+", option.inner_text())[0])
    option.click()
    window.wait(lambda: window.view.selected == chosen, "the option")
    window.wait(lambda: "Counting" not in window.text(), "the rest to be counted", 120)
    # Beside the one under Why.
    window.wait(lambda: window.text().count("Faithfulness, tried at") == 2, "how faithful it is")
    # Nothing is left to be counted: now the key only opens the tab.
    window.page.get_by_role("tab", name="Inspect").click()
    window.wait(lambda: tab.get_attribute("aria-selected") == "false", "another tab")
    window.page.keyboard.press("Shift+W")
    window.wait(lambda: tab.get_attribute("aria-selected") == "true", "the tab")
    assert "Counting" not in window.text()
    assert window.page.get_by_role("button", name=re.compile("^Look")).count() == 0


def test_options_are_muted_until_it_is_ended_and_what_is_known_stays(dashboard, open_window: Open):
    window = open_window(dashboard)
    open_tab(window)
    window.press("End")  # Of the counting, which leaves the processor to what follows.
    window.wait_for_text("Ended before all was counted")
    # More than anybody waits for, so that it is still under way when it is ended.
    for label, number in (("Options", "100"), ("Episodes", "20")):
        field = window.field(label)
        field.scroll_into_view_if_needed()
        field.fill(number)
        field.press("Enter")
    window.wait(lambda: (window.view.whole.options, window.view.whole.episodes) == (100, 20), "it")
    button(window, "Mute these").click()
    loss = window.page.get_by_role("button", name=re.compile(r"^Option \d+: a loss of")).first
    loss.wait_for(timeout=120_000)
    window.press("End")
    window.wait_for_text("What is known so far stands below.", 60)
    window.wait_for_text("episodes played")
    window.wait_for_text("asked again, it decides as recorded in")
    loss.scroll_into_view_if_needed()
    chosen = int(re.findall(r"\d+", loss.inner_text())[0])
    loss.click()
    window.wait(lambda: window.view.selected == chosen, "the option")
    window.wait_for_text(f"Mute option {chosen}")
    # The agent that is watched is another one for a while; this one is remembered.
    window.choose("Watch", "Pendulum-v1")
    window.wait_for_text("Look at the whole agent")
    window.choose("Watch", "CartPole-v1")
    window.wait_for_text("What is known so far stands below.")
