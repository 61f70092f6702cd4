"""The forest on the canvas: arranging, colouring, folding and finding, as people do it."""

import numpy as np

from ao2viz.figures.coloring import Coloring
from ao2viz.ui.look import Arrangement
from tests.browser.conftest import Open, Window


def drawn(window: Window):
    return window.dashboard._browsers[window._client_id]


def n_drawn(window: Window) -> int:
    """Options that the picture shows."""
    return int(np.count_nonzero(drawn(window)._picture.sizes))


def test_arrangement_and_colour_are_chosen_by_list_and_by_key(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Forest").click()
    window.choose("Layout", "cones")
    window.wait(lambda: window.view.look.arrangement is Arrangement.CONES, "the cones")
    window.wait_for_text("higher: nearer to its root")
    window.choose("Colour", "value")
    window.wait(lambda: window.view.look.coloring is Coloring.VALUE, "the colours")
    window.wait_for_text("expected return, by rank")
    window.page.locator("body").click(position={"x": 520, "y": 20})
    window.page.keyboard.press("l")
    window.wait_for_text("state now, and the way there")
    axes = [window.view.spec.features[i].name for i in window.view.look.axes]
    window.wait(lambda: window.field("Across").input_value() == axes[0], "the axis in its field")
    other = next(f.name for f in window.view.spec.features if f.name not in axes)
    window.choose("Across", other)
    window.wait(
        lambda: window.view.spec.features[window.view.look.axes[0]].name == other, "the axis"
    )
    window.wait(
        lambda: any(other in label.text for label in drawn(window)._overlay[1].labels),
        "the axis to be named",
    )


def test_schemas_are_folded_and_unfolded_and_depth_is_limited(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.wait(lambda: drawn(window)._picture is not None, "a picture")
    all_drawn = n_drawn(window)
    window.page.get_by_role("tab", name="Forest").click()
    window.press("Fold all")
    window.wait_for_text("hidden")
    roots = int(((window.view.forest.parents < 0) & window.view.forest.is_alive).sum())
    window.wait(lambda: n_drawn(window) == roots, "roots alone")
    window.press("Unfold all")
    window.wait(lambda: drawn(window)._picture.n_hidden == 0, "everything again")
    assert n_drawn(window) == all_drawn
    window.field("Depth").fill("1")
    window.page.keyboard.press("Enter")
    window.wait(lambda: window.view.look.deepest == 1, "the limit")
    window.wait_for_text("hidden")


def test_the_option_nearest_to_a_typed_state_is_found(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Forest").click()
    window.field("Find state").fill("0.1, 0, 4, 20")
    window.page.keyboard.press("Enter")
    state = np.array([0.1, 0, np.radians(4), np.radians(20)])
    nearest = int(np.argmin(window.view.forest.distances_to(state)))
    window.wait(lambda: window.view.selected == nearest, "the nearest option")
    window.field("Find state").fill("0.1, 0")
    window.page.keyboard.press("Enter")
    window.wait_for_text("cart position in m")
    assert window.view.selected == nearest


def test_two_browsers_see_the_same_forest_in_their_own_way(dashboard, open_window: Open):
    one, two = open_window(dashboard), open_window(dashboard)
    two.hold()
    two.page.keyboard.press("l")
    two.page.keyboard.press("c")
    two.wait(lambda: two.view.look.coloring is Coloring.VALUE, "the second browser's colours")
    assert two.view.look.arrangement is Arrangement.CONES
    assert one.view.look.arrangement is Arrangement.DISCS
    assert one.view.look.coloring is Coloring.ACTION
    one.wait_for_text("prefers push left")


def test_the_legend_covers_no_disc_and_is_as_big_as_was_thought(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    panel = window.page.locator("[data-floating-window]:has(.ao-legend)").first
    canvas = window.page.locator("canvas").first.bounding_box()

    def excess() -> tuple[float, float]:
        """By how many pixels the panel is smaller than was thought, to the right and up."""
        box = panel.bounding_box()
        width, height = drawn(window)._legend.size
        right = box["x"] + box["width"] - canvas["x"]
        return width - right, height - (canvas["y"] + canvas["height"] - box["y"])

    for _ in Coloring:
        # Covers nothing, and is not much smaller than thought.
        window.wait(lambda: excess()[0] >= -1 and -1 <= excess()[1] < 45, "the legend")
        before = window.view.look.coloring
        window.page.keyboard.press("c")
        window.wait(lambda b=before: window.view.look.coloring is not b, "other colours")
        window.page.wait_for_timeout(400)
    window.page.keyboard.press("f")

    def covers_no_disc() -> bool:
        browser = drawn(window)
        lens = browser._eye.look()
        centres, radii = browser._picture.discs
        seen, depth = lens.see(np.pad(centres, ((0, 0), (0, 1))))
        pixels = radii * lens.window[1] / 2 / np.tan(lens.fov / 2) / depth
        right, top = browser._legend.size
        beyond = np.column_stack([seen[:, 0] - right, lens.window[1] - top - seen[:, 1]])
        return bool((np.hypot(*np.maximum(beyond, 0).T) >= pixels - 2).all())

    window.page.wait_for_timeout(1000)  # The camera glides.
    window.wait(covers_no_disc, "all discs beside the legend")


def test_the_slider_says_the_step_of_the_decision_that_is_shown(dashboard, open_window: Open):
    window = open_window(dashboard, draws=True)  # As slow as it gets.
    window.wait(lambda: window.view.transport.position > 5, "the episode to play")
    # At one stroke, as when pasting: between two the page may write the step that plays.
    window.field("Step").evaluate(
        """(field) => {
          Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(field, "3");
          field.dispatchEvent(new Event("input", {bubbles: true}));
        }"""
    )
    window.wait(lambda: window.view.transport.position == 3, "the step")
    window.wait(lambda: not window.view.transport.is_playing, "the replay to hold")
    window.page.wait_for_timeout(2500)
    assert window.field("Step").input_value() == str(window.view.transport.position)
