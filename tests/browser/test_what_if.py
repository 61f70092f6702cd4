"""What if: a control is moved and path and action follow; a flip's button flips; and back."""

import re

import numpy as np

from tests.browser.conftest import Open, Window


def open_tab(window: Window) -> None:
    window.hold()
    window.press("First step")
    window.wait(lambda: window.view.transport.position == 0, "the first step")
    window.page.get_by_role("tab", name="What if").click()
    window.wait(lambda: answer_of(window) is not None, "the controls", 120)
    window.wait_for_text("HOW SURE", 120)


def answer_of(window: Window):
    return window.dashboard._browsers[window._client_id]._supposing._answer


def drawn_path(window: Window) -> str:
    overlay = window.dashboard._browsers[window._client_id]._overlay[1]
    return overlay.labels[0].text if overlay is not None and overlay.labels else ""


def supposed_action(window: Window) -> int | None:
    """What is chosen in the state that is supposed, or seen, now; None while that is not known."""
    answer, view = answer_of(window), window.view
    state = view.observation if view.supposed is None else view.supposed
    if answer is None or answer.decision is None or not np.array_equal(answer.state, state):
        return None
    return answer.decision.action


def test_a_moved_control_changes_path_and_action_and_reset_brings_them_back(
    dashboard, open_window: Open
):
    window = open_window(dashboard)
    open_tab(window)
    seen = window.view.observation.copy()
    before = drawn_path(window)
    assert not before.startswith("what if")
    action = supposed_action(window)
    track = window.page.locator(".mantine-Slider-track:visible")
    # The pole leans as far to one side as the environment allows, then to the other.
    for place in (0.98, 0.02):
        control = track.nth(track.count() - 2)
        control.scroll_into_view_if_needed()
        box = control.bounding_box()
        window.page.mouse.click(box["x"] + place * box["width"], box["y"] + box["height"] / 2)
        window.wait(lambda: window.view.supposed is not None, "the what-if")
        side = 1 if place > 0.5 else -1
        window.wait(lambda s=side: s * window.view.supposed[2] > 0.2, "the control")
        window.wait(lambda: supposed_action(window) is not None, "an answer")
        if supposed_action(window) != action:
            break
    assert supposed_action(window) != action
    name = window.view.spec.action_names[supposed_action(window)]
    window.wait(lambda: drawn_path(window).startswith("what if: option"), "the path")
    assert drawn_path(window).endswith(name)
    window.wait_for_text("A what-if, not the replay")
    window.wait_for_text("The forest shows a what-if, not this moment")
    changed = window.view.supposed
    assert (changed != seen).tolist() == [False, False, True, False]
    window.press("Reset")
    window.wait(lambda: window.view.supposed is None, "the replay's moment")
    window.wait(lambda: drawn_path(window) == before, "its path")
    window.wait(lambda: supposed_action(window) == action, "its action")
    window.wait_for_text("This is the moment of the replay")


def test_the_button_of_a_flip_flips_the_action_and_so_does_the_nearest_of_all(
    dashboard, open_window: Open
):
    window = open_window(dashboard)
    open_tab(window)
    action = supposed_action(window)
    names = window.view.spec.action_names
    flip = window.page.get_by_role("button", name=f"{names[1 - action]} at ").first
    flip.scroll_into_view_if_needed()
    flip.click()
    window.wait(lambda: window.view.supposed is not None, "the what-if")
    window.wait(lambda: supposed_action(window) == 1 - action, "the other action")
    window.press("Reset")
    window.wait(lambda: window.view.supposed is None, "the replay's moment")
    window.press("Nearest flip")
    window.wait_for_text("NEAREST FLIP OF ALL FEATURES", 60)
    # The best so far can be gone to while the search goes on.
    window.wait_for_text("then it chooses", 120)
    window.press("Go there")
    window.wait(lambda: window.view.supposed is not None, "the nearest flip")
    window.wait(lambda: supposed_action(window) == 1 - action, "the other action")
    # Another step is another moment: the what-if ends, and the path is the replay's again.
    window.press("Step forward")
    window.wait(lambda: window.view.supposed is None, "the replay's moment")
    window.wait(lambda: not drawn_path(window).startswith("what if"), "its path")


def test_an_episode_is_forgotten_from_the_page_and_a_changed_moment_is_gone_to(
    dashboard, open_window: Open
):
    window = open_window(dashboard)
    open_tab(window)
    box = window.field("Forget")
    box.scroll_into_view_if_needed()
    box.fill("1")
    box.press("Enter")
    window.wait(lambda: window.view.again.episode == 1, "the episode")
    window.press("Forget it")
    window.wait_for_text("Training episode 1 had", 120)
    window.wait_for_text("learned again, it decides the same in")
    moment = window.page.get_by_role("button", name=re.compile(r"step \d+: .* → ")).first
    moment.scroll_into_view_if_needed()
    words = moment.inner_text()
    moment.click()
    step = int(words.partition("step ")[2].partition(":")[0])
    window.wait(lambda: window.view.transport.position == step, "the moment")
