"""Typed settings: checked, told apart from defaults, started with, and given to a run."""

from dataclasses import replace

import pytest

from ao2viz.agent import AO2
from ao2viz.core.config import Preset, make_config
from ao2viz.training.states import ChangeSettings, RunStatus, SetShare, Start
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.commands import Press, RunButton
from ao2viz.ui.defaults import DefaultsStore, find_defaults
from ao2viz.ui.dialog_commands import (
    ApplySettings,
    ChooseShare,
    CloseDialog,
    Dialog,
    EditSetting,
    OpenDialog,
    ResetSettings,
)
from ao2viz.ui.downloads import Notify
from ao2viz.ui.html_settings import caption
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import OTHER_ENV, Form, Session
from ao2viz.ui.settings import setting_rows
from ao2viz.ui.view import project
from ao2viz.ui.world import World


@pytest.fixture(scope="module")
def world() -> World:
    return World(env_ids=("CartPole-v1",), defaults={"CartPole-v1": find_defaults("CartPole-v1")})


def typed(world: World, **settings: str) -> Session:
    session = Session()
    for name, text in settings.items():
        session, effects = reduce(session, EditSetting(name, text), world)
        assert effects == ()
    return session


def test_a_run_starts_with_what_was_typed_and_differs(world):
    session = typed(world, gamma="0.9", slip="0.05", decide_by="vote")
    _, effects = reduce(session, Press(RunButton.START), world)
    # The slip is the default.
    assert effects == (Start("CartPole-v1", overrides={"gamma": 0.9, "decide_by": "vote"}),)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("gamma", "3", "Expected gamma between 1e-06 and 1, but got 3."),
        ("levels", "2.5", "Expected levels to be a whole number, but got 2.5."),
        ("slip", "NaN", "Expected slip to be a finite number, but got nan."),
        ("slip", "much", "Expected slip to be a finite number, but got 'much'."),
        ("slip", "[" * 5000, "Expected slip to be a finite number, but got"),
        ("slip", "9" * 400, "Expected slip between 0 and 1, but got 999"),
        ("slip", "9" * 5000, "Expected slip to be a finite number, but got '999"),
        ("slip", "true", "Expected slip to be a finite number, but got True."),
        ("decide_by", "luck", "Expected decide_by to be one of 'vote', 'path', but got 'luck'."),
    ],
)
def test_what_cannot_be_is_told_in_one_line_and_starts_nothing(world, name, text, words):
    session = typed(world, **{"voters": "9", name: text})
    after, effects = reduce(session, Press(RunButton.START), world)
    assert after == session
    assert len(effects) == 1
    assert isinstance(effects[0], Notify)
    assert effects[0].is_error
    assert effects[0].body.startswith(words)
    assert "\n" not in effects[0].body
    row = next(r for r in project(session, world).settings if r.setting.name == name)
    assert row.problem == effects[0].body
    assert not row.differs


def test_an_emptied_field_and_a_reset_give_the_default_back(world):
    session = typed(world, gamma="0.9", slip="0.2")
    emptied, _ = reduce(session, EditSetting("gamma", " "), world)
    assert dict(emptied.form.settings) == {"slip": "0.2"}
    reset, _ = reduce(session, ResetSettings(), world)
    assert reset.form.settings == {}
    assert reset.form.resets == session.form.resets + 1
    assert reduce(reset, Press(RunButton.START), world)[1] == (Start("CartPole-v1"),)


def test_what_is_typed_for_one_preset_is_no_setting_of_the_other(world):
    session = typed(world, gamma="0.9", levels="4", threshold="0.8")
    paper = replace(session, form=replace(session.form, preset=Preset.PAPER))
    _, (start,) = reduce(paper, Press(RunButton.START), world)
    assert start.overrides == {"gamma": 0.9, "threshold": 0.8}


def test_a_run_gets_only_what_can_change_in_it(world):
    config = make_config(Preset.ANTICIPATING, {})
    running = replace(world, update=RunUpdate(RunStatus.RUNNING, config=config))
    session = typed(world, epsilon_end="0.2", levels="5")
    assert reduce(session, ApplySettings(), running)[1] == (ChangeSettings({"epsilon_end": 0.2}),)
    for settings, update, words in (
        ({"levels": "5"}, running.update, "Nothing that is typed would change"),
        ({"epsilon_end": "2"}, running.update, "Expected epsilon_end between 0 and 1, but got 2."),
        ({"slip": "0.1"}, RunUpdate(), "There is no run to change."),
        (
            {"slip": "0.1"},
            RunUpdate(RunStatus.PAUSED, config=make_config(Preset.PAPER, {})),
            "The run under way is of the paper preset.",
        ),
    ):
        session = typed(world, **settings)
        _, (told,) = reduce(session, ApplySettings(), replace(world, update=update))
        assert isinstance(told, Notify)
        assert told.body.startswith(words)


def test_the_dialog_shows_what_is_the_default_what_is_typed_and_what_the_run_has():
    config = make_config(Preset.ANTICIPATING, {"slip": 0.3})
    form = Form(settings={"gamma": "0.9", "slip": "0.1", "backups": "-1"})
    rows = {r.setting.name: r for r in setting_rows(form, None, config)}
    assert (rows["gamma"].text, rows["gamma"].differs, rows["gamma"].in_run) == ("0.9", True, 0.995)
    assert "the run has 0.3" in caption(rows["slip"])
    assert "changed" in caption(rows["gamma"])
    assert 'role="alert"' in caption(rows["backups"])
    assert "at once" in caption(rows["slip"])
    assert "in a new run" in caption(rows["levels"])
    assert not rows["voters"].differs
    evil = setting_rows(Form(settings={"slip": "<img src=x>"}), None, None)
    assert not any("<img" in caption(row) for row in evil)


def test_dialogs_open_close_and_give_way_to_one_another(world):
    session, _ = reduce(Session(), OpenDialog(Dialog.SETTINGS), world)
    assert project(session, world).dialog is Dialog.SETTINGS
    assert len(project(session, world).settings) > 20
    session, _ = reduce(session, OpenDialog(Dialog.HELP), world)
    assert session.dialog is Dialog.HELP
    assert reduce(session, OpenDialog(Dialog.HELP), world)[0].dialog is None
    assert reduce(session, CloseDialog(), world)[0].dialog is None


def test_the_share_of_learning_goes_to_the_run(world):
    assert reduce(Session(), ChooseShare(0.8), world)[1] == (SetShare(0.8),)


def test_defaults_of_an_environment_are_found_once_and_problems_leave_none():
    store = DefaultsStore()
    try:
        for env_id in ("CartPole-v1", "Nowhere-v7", ""):
            store.ask(env_id)
    finally:
        store._thread.shutdown(wait=True)
    assert store.poll()
    assert not store.poll()
    assert set(store.known) == {"CartPole-v1"}
    for preset in Preset:
        assert store.known["CartPole-v1"][preset] == AO2("CartPole-v1", preset).config
    assert not Form(env=OTHER_ENV, custom_env="os:system").may_be_made
