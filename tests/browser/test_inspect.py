"""The inspector: a weight opens to its reasons, leads on, and there is a way back."""

from tests.browser.conftest import Open


def test_a_weight_opens_to_its_reasons_and_leads_on_and_back(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.press("First step")
    window.wait(lambda: window.view.transport.position == 0, "the first step")
    window.press("Decided")
    option = int(window.view.decision.path[-1])
    window.wait(lambda: window.view.selected == option, "the option that decided")
    action = window.view.decision.action
    name = window.view.spec.action_names[action]
    window.choose("Open weight", name)
    window.wait_for_text(f"for {name}".upper())
    window.wait_for_text("on the way", 60)
    # An option where the imagined story ends is one click away, and back again.
    leads = window.page.get_by_role("button", name="worth").first
    end = int(leads.inner_text().split(" ")[0])
    leads.click()
    window.wait(lambda: window.view.selected == end, "where it leads")
    window.press("Back")
    window.wait(
        lambda: (window.view.selected, window.view.opened) == (option, action), "the way back"
    )
    window.wait_for_text("on the way", 60)
    # So is a recorded moment at which it had a say.
    moment = window.page.get_by_role("button", name="Episode 1, step").last
    step = int(moment.inner_text().split("step ")[1].split(":")[0])
    moment.click()
    window.wait(lambda: window.view.transport.position == step, "the moment")
    assert option in window.view.decision.voters
    assert not window.view.transport.is_playing


def test_where_it_expects_to_go_is_told_and_can_be_hidden(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.press("First step")
    window.wait_for_text("steps ahead", 60)
    browser = window.dashboard._browsers[window._client_id]
    window.wait(lambda: len(browser._overlay[1].ahead[0]) > 0, "the imagined path")
    window.page.locator("body").click(position={"x": 520, "y": 20})
    window.page.keyboard.press("r")
    window.wait(lambda: len(browser._overlay[1].ahead[0]) == 0, "it to be hidden")
    window.wait(lambda: "steps ahead" not in window.text(), "its words to go")
