"""Controls show what the session says, without taking back what a person has just done."""

import pytest
import viser

from ao2viz.ui.mirror import Mirror
from ao2viz.ui.security import make_server


@pytest.fixture(scope="module")
def gui():
    server = make_server("127.0.0.1", 0)
    yield server.gui
    server.stop()


def by_person(handle: viser.GuiInputHandle, value: object) -> None:
    """What viser does when a browser sends a value."""
    handle._impl.value = value


def test_an_edit_that_the_loop_has_not_read_yet_is_kept(gui):
    number = gui.add_number("Steps", 20_000)
    mirror = Mirror(number)
    by_person(number, 500)
    mirror.show(20_000)
    assert number.value == 500
    mirror.show(500)
    assert number.value == 500


def test_what_the_program_changes_is_shown(gui):
    text = gui.add_text("Name", "")
    mirror = Mirror(text)
    mirror.show("a")
    mirror.show("b")
    assert text.value == "b"


def test_a_list_that_changes_keeps_the_right_choice(gui):
    choice = gui.add_dropdown("Watch", ["a"])
    mirror = Mirror(choice)
    mirror.show_among(("b", "c"), "c")
    assert (choice.options, choice.value) == (("b", "c"), "c")
    mirror.show_among(("c", "d"), "c")
    assert choice.value == "c"
    by_person(choice, "d")
    mirror.show_among(("c", "d"), "c")
    assert choice.value == "d"


def test_a_slider_never_shows_more_than_its_range(gui):
    slider = gui.add_slider("Step", 0, 10, 1, 9)
    mirror = Mirror(slider)
    mirror.show_within(5, 5)
    assert (slider.max, slider.value) == (5, 5)
    mirror.show_within(500, 400)
    assert (slider.max, slider.value) == (500, 400)


def test_a_slider_that_a_person_moved_meanwhile_is_told_its_value_again(gui, monkeypatch):
    slider = gui.add_slider("Step", 0, 10, 1, 9)
    mirror = Mirror(slider)
    by_person(slider, 4)
    sent = []
    monkeypatch.setattr(
        slider._impl.gui_api._websock_interface, "queue_message", lambda m: sent.append(m.updates)
    )
    mirror.show(4)  # Viser sends nothing: it knows that the slider says 4. A browser may not.
    assert sent == []
    mirror.insist()
    assert sent[-1] == {"value": 4}
    assert slider.value == 4
