"""Watching a recorded episode: it plays, it steps, it shows what was recorded."""

import io

import numpy as np
from PIL import Image

from ao2viz.explain.contrast import explain_why_not, tell_why_not
from ao2viz.explain.words import number
from ao2viz.figures.palette import PATH
from ao2viz.ui.tones import to_albedo
from tests.browser.conftest import Open, Window

_ONLY_CANVAS = "* {visibility: hidden !important} canvas {visibility: visible !important}"


def test_it_opens_and_plays_with_the_path_lit(dashboard, open_window: Open):
    window = open_window(dashboard, draws=True)
    window.wait(lambda: window.view.transport.position > 3, "the episode to play")
    assert window.view.source.name == "CartPole-v1.ao2"
    # While it plays: a path of one option, at which it may be held, lights up little.
    window.wait(lambda: pink(window) > 20, "the path to light up")
    window.hold()
    view = window.view
    told = (
        view.spec.action_names[view.decision.action],
        "Path to the most similar option",
        *(f" {option}" for option in view.decision.path),
    )
    for what in told:
        window.wait(lambda what=what: what.upper() in window.text().upper(), f"{what!r} in words")
    window.press("Last step")
    window.wait(lambda: window.view.decision is None, "the end of the episode")
    window.wait(lambda: pink(window) == 0, "the path to go out where nothing is decided")


def pink(window: Window) -> int:
    """Pixels of the forest in the colour of the path, without the legend and names above it."""
    shot = window.page.locator("canvas").first.screenshot(style=_ONLY_CANVAS)
    pixels = np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)
    assert to_albedo(np.array(PATH, np.uint8)).shape == (3,)
    return int((np.abs(pixels - PATH).max(axis=2) < 12).sum())


def test_options_have_the_colours_of_the_legend(dashboard, open_window: Open):
    window = open_window(dashboard, draws=True)
    window.hold()
    shown = window.page.locator(".ao-legend .ao-swatch")
    window.wait(lambda: shown.count() > 2, "the legend")
    swatches = shown.evaluate_all(
        "all => all.map(s => getComputedStyle(s).backgroundColor.match(/\\d+/g).map(Number))"
    )
    blue, orange = swatches[0], swatches[1]

    def seen(rgb) -> int:
        shot = window.page.locator("canvas").first.screenshot()
        pixels = np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)
        return int((np.abs(pixels - rgb).max(axis=2) < 45).sum())

    window.wait(lambda: seen(blue) > 100 and seen(orange) > 100, "options in both colours")


def test_stepping_shows_the_recorded_decision_and_it_was_executed(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    episode = window.view.episode
    window.press("First step")
    window.wait(lambda: window.view.transport.position == 0, "the first step")
    for t in (0, 1, 2, 3):
        expected = episode.decisions[t]
        window.wait(lambda t=t: window.view.transport.position == t, f"step {t}")
        assert window.view.decision is expected
        assert expected.action == episode.actions[t]  # Shown is recorded is executed.
        stack = window.page.locator(".ao-path")
        action = window.view.spec.action_names[expected.action]
        told = [*map(str, expected.path.tolist()), action]
        window.wait(
            lambda told=told, stack=stack: stack.locator("li b").all_inner_texts() == told,
            f"the stack of step {t}: {told}",
        )
        window.press("Step forward")
    window.press("Step back")
    window.wait(lambda: window.view.transport.position == 3, "the step before")
    assert window.view.decision is episode.decisions[3]
    window.press("Last step")
    window.wait_for_text("End of the episode")


def test_keys_move_the_replay(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    before = window.view.transport.position
    window.page.keyboard.press("d")
    window.wait(lambda: window.view.transport.position == before + 1, "D to step forward")
    window.page.keyboard.press("a")
    window.wait(lambda: window.view.transport.position == before, "A to step back")
    window.page.keyboard.press("p")
    window.wait(lambda: window.view.transport.is_playing, "P to play")


def test_another_agent_and_another_episode_can_be_chosen(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.choose("Watch", "Pendulum-v1")
    window.wait_for_text("Pendulum swing-up")
    window.choose("Episode", "2: return")
    window.wait(lambda: window.view.episode_index == 1, "the second episode")
    assert window.view.episode is window.dashboard._library.opened[window.view.source].episodes[1]


def test_the_picture_follows_the_step(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    picture = window.page.locator("img").first
    window.press("First step")
    window.page.wait_for_timeout(1500)
    first = picture.screenshot()
    window.press("Last step")
    window.wait(lambda: picture.screenshot() != first, "another picture")


def test_clicking_an_option_shows_its_value(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    browser = window.dashboard._browsers[window._client_id]
    window.wait(lambda: browser._picture is not None, "a picture")
    option = 5
    window.wait(lambda: on_screen(window, option) is not None, "the camera")
    stands_still(window, option)
    x, y = on_screen(window, option)
    box = window.page.locator("canvas").first.bounding_box()
    window.page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
    window.wait(lambda: window.view.selected == option, "the option to be selected")
    window.wait_for_text(f"Option {option}")
    value = window.view.forest.values[option]
    degrees = f"{abs(np.degrees(value[2])):.3g}"[:3]
    window.wait_for_text(degrees)
    # What is related can be clicked as well.
    parent = int(window.view.forest.parents[option])
    related = window.page.get_by_role("button", name=f"{parent} ·")
    if parent >= 0:
        related.first.click()
        window.wait(lambda: window.view.selected == parent, "the parent to be selected")


def on_screen(window: Window, option: int) -> tuple[float, float] | None:
    """Where an option is on the canvas, from 0 to 1, by the camera of this browser."""
    client = window.dashboard._server.get_clients()[window._client_id]
    camera = client.camera
    point = window.dashboard._browsers[window._client_id]._picture.positions[option]
    toward = np.array(point) - camera.position
    if camera.position[2] < 10:
        return None
    height = np.tan(camera.fov / 2) * -toward[2]
    return (
        float(0.5 + toward[0] / height / camera.aspect / 2),
        float(0.5 - toward[1] / height / 2),
    )


def stands_still(window: Window, option: int) -> None:
    """Waits until the camera has stopped gliding."""
    places = [on_screen(window, option)]

    def is_still() -> bool:
        window.page.wait_for_timeout(800)
        places.append(on_screen(window, option))
        return places[-1] == places[-2]

    window.wait(is_still, "the camera to stand still")


def test_an_option_is_found_by_its_id(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.field("Option id").fill("7")
    window.wait_for_text("Option 7")
    window.field("Option id").fill("99999")
    window.wait_for_text("There is no option 99999")


def test_two_browsers_have_their_own_place_and_selection(dashboard, open_window: Open):
    one, two = open_window(dashboard), open_window(dashboard)
    one.hold()
    two.hold()
    one.press("First step")
    two.press("Last step")
    one.wait(lambda: one.view.transport.position == 0, "the first browser at the start")
    two.wait(lambda: two.view.decision is None, "the second browser at the end")
    two.field("Option id").fill("3")
    two.wait(lambda: two.view.selected == 3, "a selection")
    assert one.view.selected == -1
    assert one.view.transport.position == 0
    two.choose("Watch", "Pendulum-v1")
    two.wait(lambda: two.view.source.name == "Pendulum-v1.ao2", "another agent")
    assert one.view.source.name == "CartPole-v1.ao2"


def test_everything_is_reachable_on_a_small_screen(dashboard, open_window: Open):
    window = open_window(dashboard, size={"width": 1024, "height": 768})
    window.hold()
    outside = """() => [...document.querySelectorAll('button, input, .ao, .ao-legend')]
        .filter(e => {
            const r = e.getBoundingClientRect();
            return r.width > 0 && (r.left < -1 || r.right > innerWidth + 1);
        }).map(e => e.outerHTML.slice(0, 120))"""
    window.wait_for_none(lambda: window.page.evaluate(outside))
    for name in ("First step", "Last step", "Start", "Pause", "Stop", "Step", "Episode", "Save"):
        box = window.page.get_by_role("button", name=name, exact=True).bounding_box()
        assert box is not None, name
        assert box["y"] + box["height"] <= 768, name


def test_rows_of_buttons_are_rows(dashboard, open_window: Open):
    """The style sheet leans on how viser lays out its page; this tells if that changes."""
    window = open_window(dashboard)
    for names in (
        ("First step", "Step back", "Step forward", "Last step"),
        ("Start", "Pause", "Stop"),
        ("Step", "Episode", "Save"),
        ("Fit", "Path", "Tidy"),
    ):
        boxes = [
            window.page.get_by_role("button", name=name, exact=True).bounding_box()
            for name in names
        ]
        assert len({round(box["y"]) for box in boxes}) == 1, names
        assert [box["x"] for box in boxes] == sorted(box["x"] for box in boxes)


def test_why_not_each_other_action_opens_to_what_stood_against_it(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.press("First step")
    window.wait(lambda: window.view.transport.position == 0, "the first step")
    view = window.view
    (other,) = {0, 1} - {view.decision.action}
    why_not = explain_why_not(view.decision, other, view.forest)
    told = tell_why_not(why_not, view.spec)
    # Of this step: that of the one before it may still stand there.
    words = f"{view.spec.action_names[other]}: {number(abs(why_not.advantage))} "
    summary = window.page.locator("summary", has_text=words)
    summary.wait_for()
    assert told not in window.text()
    summary.focus()
    window.page.keyboard.press("Enter")
    window.wait_for_text(told)
    window.wait_for_text("Known: an option lies within")
