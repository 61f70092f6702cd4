"""Theme, motion and the hint of a first visit, as plain values."""

import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ao2viz.figures.palette import Theme
from ao2viz.ui.appearance import (
    Appearance,
    ChooseMotion,
    ChooseTheme,
    DismissHint,
    Recall,
    Remember,
    SwitchTheme,
    from_text,
    to_text,
)
from ao2viz.ui.dialog_commands import CloseDialog, Dialog
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session
from ao2viz.ui.view import project
from ao2viz.ui.world import World

APPEARANCES = st.builds(
    Appearance,
    theme=st.none() | st.sampled_from(Theme),
    is_still=st.none() | st.booleans(),
    hint_is_gone=st.booleans(),
    system_is_light=st.booleans(),
    system_is_still=st.booleans(),
    is_known=st.just(True),
)


def told(appearance: Appearance) -> str:
    """What a browser answers that kept the text of an appearance."""
    system = {"light": appearance.system_is_light, "still": appearance.system_is_still}
    return json.dumps({**system, "chosen": to_text(appearance)})


@given(APPEARANCES)
def test_a_browser_finds_again_what_was_chosen_in_it(appearance):
    assert from_text(told(appearance)) == appearance


OBJECTS = st.dictionaries(st.text(), st.integers() | st.text()).map(json.dumps)


@given(st.none() | st.text() | OBJECTS)
def test_whatever_makes_no_sense_is_a_first_visit(text):
    assert from_text(text) == Appearance(hint_is_gone=False, is_known=True)


@pytest.mark.parametrize("chosen", ["[]", "{", '{"theme": "pink", "is_still": 3}', 7, None])
def test_nonsense_that_was_kept_is_a_first_visit_as_well(chosen):
    text = json.dumps({"light": True, "still": False, "chosen": chosen})
    assert from_text(text).shown_theme is Theme.LIGHT
    assert not from_text(text).hint_is_gone


def test_the_system_decides_until_somebody_chooses():
    light = Appearance(system_is_light=True, system_is_still=True)
    assert light.shown_theme is Theme.LIGHT
    assert light.rests
    chosen = replace(light, theme=Theme.DARK, is_still=False)
    assert chosen.shown_theme is Theme.DARK
    assert not chosen.rests
    assert Appearance().shown_theme is Theme.DARK


@pytest.mark.parametrize(
    ("command", "after"),
    [
        (ChooseTheme(Theme.LIGHT), {"theme": Theme.LIGHT}),
        (ChooseTheme(None), {"theme": None}),
        (SwitchTheme(), {"theme": Theme.LIGHT}),
        (ChooseMotion(True), {"is_still": True}),
        (DismissHint(), {"hint_is_gone": True}),
    ],
)
def test_every_choice_is_kept_by_the_browser(command, after):
    before = Appearance(hint_is_gone=False, is_known=True)
    session, effects = reduce(Session(appearance=before), command, World())
    assert session.appearance == replace(before, **after)
    assert effects == (Remember(to_text(session.appearance)),)


def test_switching_twice_comes_back():
    session = Session(appearance=Appearance(system_is_light=True))
    for theme in (Theme.DARK, Theme.LIGHT):
        session, _ = reduce(session, SwitchTheme(), World())
        assert session.appearance.shown_theme is theme


def test_escape_closes_a_dialog_first_and_then_the_hint():
    session = Session(appearance=Appearance(hint_is_gone=False), dialog=Dialog.HELP)
    session, effects = reduce(session, CloseDialog(), World())
    assert session.dialog is None
    assert not session.appearance.hint_is_gone
    assert effects == ()
    session, effects = reduce(session, CloseDialog(), World())
    assert session.appearance.hint_is_gone
    assert effects == (Remember(to_text(session.appearance)),)
    assert reduce(session, CloseDialog(), World()) == (session, ())


def test_nothing_plays_for_whoever_wants_nothing_to_move():
    still = from_text('{"still": true}')
    session, effects = reduce(Session(), Recall(still), World())
    assert not session.is_playing
    assert effects == ()
    session, _ = reduce(Session(), Recall(from_text("{}")), World())
    assert session.is_playing
    assert project(session, World()).look.is_still is False
    assert project(replace(session, appearance=still), World()).look.is_still is True


def test_the_picture_is_coloured_for_the_theme():
    dark, light = (Session(appearance=Appearance(theme=theme)) for theme in Theme)
    assert project(dark, World()).look.theme is Theme.DARK
    assert project(light, World()).look.theme is Theme.LIGHT
