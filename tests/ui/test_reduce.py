"""Commands change one browser's session and ask for effects; plain functions, no server."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ao2viz.core.config import PaperConfig, Preset
from ao2viz.core.decision import NO_OPTION, DecideBy
from ao2viz.figures.coloring import Coloring
from ao2viz.recording.episode import Episode
from ao2viz.training.states import (
    TRANSITIONS,
    Pause,
    Resume,
    RunEpisode,
    RunStatus,
    Save,
    SetDecideBy,
    SetSpeed,
    Start,
    Step,
    Stop,
    TrainOn,
)
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.commands import (
    ChooseDecideBy,
    ChooseEpisode,
    ChooseSource,
    ConfirmOverwrite,
    Edit,
    Field,
    FindState,
    Fit,
    Move,
    Pick,
    Press,
    RunButton,
    Seek,
    Select,
    SetTrainingSpeed,
    TidyUp,
    Transport,
)
from ao2viz.ui.downloads import Notify
from ao2viz.ui.look import Look
from ao2viz.ui.reduce import PickOption, advance, follow, reduce
from ao2viz.ui.replay_commands import SetPlaySpeed
from ao2viz.ui.session import OTHER_ENV, Form, Place, Session
from ao2viz.ui.view import project
from ao2viz.ui.world import LoadFailure, ShelfItem, World
from tests.forests import cartpole, decision, small_view
from tests.ui.agents import saved_agent

FILE = Path("/agents/one.ao2")


def episode(length: int, **changes: object) -> Episode:
    made = Episode(
        env_id="CartPole-v1",
        seed=1,
        observations=np.zeros((length + 1, 4)),
        actions=np.ones(length, np.int64),
        rewards=np.ones(length),
        decisions=tuple(decision(action=t % 2) for t in range(length)),
        terminated=True,
        truncated=False,
    )
    return replace(made, **changes)  # pyright: ignore[reportArgumentType]


def world(update: RunUpdate | None = None, **more) -> World:
    agent = saved_agent(episodes=(episode(10), episode(4)))
    return World(
        shelf=(ShelfItem(FILE, "one"),),
        opened={FILE: agent},
        update=update or RunUpdate(),
        **more,
    )


def watching(position: float = 0.0, **more) -> Session:
    return Session(**{"source": FILE, "position": position, **more})


def after(session: Session, command, w: World | None = None) -> Session:
    return reduce(session, command, w or world())[0]


@pytest.mark.parametrize(
    ("to", "position"),
    [(Transport.FIRST, 0), (Transport.BACK, 4), (Transport.FORWARD, 6), (Transport.LAST, 10)],
)
def test_the_transport_moves_and_holds(to, position):
    moved = after(watching(5.7), Move(to))
    assert moved.position == position
    assert not moved.is_playing


def test_the_transport_stays_inside_the_episode():
    assert after(watching(0.0), Move(Transport.BACK)).position == 0
    assert after(watching(10.0), Move(Transport.FORWARD)).position == 10
    assert after(watching(0.0), Seek(99)).position == 10


def test_play_holds_goes_on_and_begins_again_at_the_end():
    held = after(watching(3.0), Move(Transport.PLAY))
    assert not held.is_playing
    assert after(held, Move(Transport.PLAY)).is_playing
    again = after(watching(10.0, is_playing=False), Move(Transport.PLAY))
    assert again.is_playing
    assert again.position == 0


def test_playing_advances_with_time_and_speed_and_stops_at_the_end():
    fast = after(watching(), SetPlaySpeed(4.0))
    assert advance(fast, world(), 0.1).position == pytest.approx(4.0)
    ended = advance(fast, world(), 5.0)
    assert ended.position == 10
    assert not ended.is_playing
    assert advance(ended, world(), 5.0) is ended


def test_another_episode_or_agent_begins_at_its_start():
    assert after(watching(5.0), ChooseEpisode(1)).position == 0
    other = after(watching(5.0, selected=2, episode=1), ChooseSource(Path("/agents/two.ao2")))
    assert (other.position, other.selected, other.episode) == (0, NO_OPTION, 0)
    assert other.is_playing


def test_choosing_what_is_watched_already_changes_nothing():
    session = watching(5.0, selected=2)
    assert after(session, ChooseSource(FILE)) == session


def test_options_are_selected_if_they_exist():
    assert after(watching(), Select(4)).selected == 4
    session, effects = reduce(watching(selected=1), Select(77), world())
    assert session.selected == 1
    assert effects == (Notify("Not here", "There is no option 77 here."),)
    assert after(watching(selected=1), Select(NO_OPTION)).selected == NO_OPTION


def test_whoever_looks_for_a_state_is_told_which_option_is_the_nearest():
    session, effects = reduce(watching(selected=4), FindState("0.1, 0.2, 3.4, 0"), world())
    assert session.selected == 4  # Also where it was selected already.
    (told,) = effects
    assert isinstance(told, Notify)
    assert told.body.startswith("Option 4 is the nearest, ")
    assert reduce(watching(), FindState(" "), world())[1] == ()


def test_a_click_on_the_canvas_asks_the_scene():
    pick = Pick((0.0, 0.0, 9.0), (0.0, 0.0, -1.0))
    assert reduce(watching(), pick, world()) == (watching(), (PickOption(pick),))


def test_fitting_and_tidying_are_counted():
    assert after(watching(), Fit()).fits == 1
    tidied = after(watching(), TidyUp())
    assert (tidied.tidies, tidied.fits) == (1, 1)


def test_start_uses_the_form_and_switches_to_live():
    session = watching()
    for field, value in (
        (Field.ENV, "Pendulum-v1"),
        (Field.PRESET, "paper"),
        (Field.SEED, 7),
        (Field.STEPS, 123),
    ):
        session = after(session, Edit(field, value))
    session, effects = reduce(session, Press(RunButton.START), world())
    assert session.source is None
    assert effects == (Start("Pendulum-v1", Preset.PAPER, 7, 123),)


@pytest.mark.parametrize(("typed", "problem"), [("  ", "Type the Gym"), ("os:Env", "colon")])
def test_a_typed_environment_must_be_a_plain_id(typed, problem):
    session = Session(form=Form(env=OTHER_ENV, custom_env=typed))
    kept, effects = reduce(session, Press(RunButton.START), world())
    assert kept == session
    assert isinstance(effects[0], Notify)
    assert problem in effects[0].body


@pytest.mark.parametrize(
    ("status", "button", "command"),
    [
        (RunStatus.RUNNING, RunButton.PAUSE, Pause()),
        (RunStatus.PAUSED, RunButton.PAUSE, Resume()),
        (RunStatus.FAILED, RunButton.PAUSE, Resume()),
        (RunStatus.PAUSED, RunButton.STEP, Step()),
        (RunStatus.RUNNING, RunButton.STOP, Stop()),
    ],
)
def test_buttons_ask_what_fits_the_run(status, button, command):
    assert reduce(Session(), Press(button), world(RunUpdate(status)))[1] == (command,)


@pytest.mark.parametrize("status", list(RunStatus))
def test_a_button_is_enabled_exactly_if_the_table_allows_it(status):
    view = project(Session(), world(RunUpdate(status)))
    for button in RunButton:
        effects = reduce(Session(), Press(button), world(RunUpdate(status)))[1]
        if button in view.enabled:
            kinds = {type(effect) for effect in effects} or {Save}  # It may ask first.
            assert all((status, kind) in TRANSITIONS for kind in kinds)
        else:
            asked = {
                RunButton.START: (Start,),
                RunButton.TRAIN_ON: (TrainOn,),
                RunButton.PAUSE: (Pause, Resume),
                RunButton.STEP: (Step,),
                RunButton.EPISODE: (RunEpisode,),
                RunButton.STOP: (Stop,),
                RunButton.SAVE: (Save,),
            }[button]
            assert not any((status, kind) in TRANSITIONS for kind in asked)
            assert isinstance(effects[0], Notify)


def test_training_on_goes_on_with_the_run_that_ended_or_with_the_file_that_is_watched():
    ended = world(RunUpdate(RunStatus.FINISHED))
    live = Session(source=None, form=Form(steps=70))
    assert reduce(live, Press(RunButton.TRAIN_ON), ended)[1] == (TrainOn(70),)
    session, effects = reduce(watching(form=Form(steps=70)), Press(RunButton.TRAIN_ON), world())
    assert session.source is None
    agent = world().opened[watching().source]
    assert effects == (
        Start(agent.spec.env_id, agent.preset, agent.seed, 70, resume_from=watching().source),
    )
    elsewhere = replace(world(), env_ids=(f"mine:{agent.spec.env_id}",))
    (start,) = reduce(watching(), Press(RunButton.TRAIN_ON), elsewhere)[1]
    assert start.env_id == f"mine:{agent.spec.env_id}"
    still_opening = replace(world(), opened={})
    assert RunButton.TRAIN_ON not in project(watching(), still_opening).enabled


def test_speed_and_decide_by_go_to_the_run():
    assert reduce(Session(), SetTrainingSpeed(30.0), world())[1] == (SetSpeed(30.0),)
    chosen = reduce(Session(), ChooseDecideBy(DecideBy.PATH), world())[1]
    assert chosen == (SetDecideBy(DecideBy.PATH),)


def saving(name: str, folder: Path):
    session = Session(form=Form(file_name=name))
    held = world(RunUpdate(RunStatus.PAUSED), folder=folder)
    return reduce(session, Press(RunButton.SAVE), held)


def test_saving_writes_into_the_folder(tmp_path):
    assert saving("good one", tmp_path)[1] == (Save(tmp_path / "good one.ao2"),)
    assert saving("named.ao2", tmp_path)[1] == (Save(tmp_path / "named.ao2"),)


@pytest.mark.parametrize("name", ["", "../up", "/etc/passwd", "a\\b", ".hidden", "a" * 200, "x\0"])
def test_names_that_lead_elsewhere_are_refused(name, tmp_path):
    session, effects = saving(name, tmp_path)
    assert isinstance(effects[0], Notify)
    assert effects[0].is_error
    assert session.overwrite is None


def test_overwriting_asks_first(tmp_path):
    path = tmp_path / "there.ao2"
    path.write_bytes(b"old")
    session, effects = saving("there", tmp_path)
    assert effects == ()
    assert session.overwrite == path
    kept, effects = reduce(session, ConfirmOverwrite(False), world())
    assert (kept.overwrite, effects) == (None, ())
    replaced, effects = reduce(session, ConfirmOverwrite(True), world())
    assert (replaced.overwrite, effects) == (None, (Save(path),))


def test_a_browser_that_watches_the_run_stands_at_its_latest_step():
    held = RunUpdate(RunStatus.PAUSED, episode=episode(6))
    session = follow(Session(source=None), RunUpdate(RunStatus.RUNNING), held)
    assert session.position == 5
    assert not session.is_playing
    elsewhere = watching(3.0)
    assert follow(elsewhere, RunUpdate(RunStatus.RUNNING), held) is elsewhere


def test_the_recorded_decision_of_each_step_is_shown():
    w = world()
    recorded = w.opened[FILE].episodes[0]
    for t in range(10):
        view = project(watching(float(t)), w)
        assert view.decision is recorded.decisions[t]
        assert view.transport.position == t


def test_the_end_of_an_episode_is_told():
    view = project(watching(10.0), world())
    assert view.decision is None
    assert view.notice == "End of the episode: the task itself ended. 10 steps, return 10.0."


def test_a_running_run_shows_its_latest_decision_and_picture():
    latest = decision()
    update = RunUpdate(
        RunStatus.RUNNING,
        spec=cartpole(),
        forest=small_view(),
        decision=latest,
        frame=b"jpeg",
        episode=episode(3),
    )
    view = project(Session(source=None), world(update))
    assert view.decision is latest
    assert view.frame == b"jpeg"
    assert not view.transport.is_enabled


def test_a_held_run_can_be_stepped_through():
    update = RunUpdate(RunStatus.PAUSED, spec=cartpole(), episode=episode(5), frame=b"jpeg")
    w = world(update)
    session = after(Session(source=None, position=4.0), Move(Transport.BACK), w)
    view = project(session, w)
    assert view.decision is update.episode.decisions[3]
    assert view.frame is None
    assert view.transport.is_enabled


@pytest.mark.parametrize(
    ("opened", "words"),
    [
        ({}, "Opening one.ao2"),
        ({FILE: LoadFailure("Cannot open one.ao2: broken")}, "Cannot open one.ao2: broken"),
        ({FILE: saved_agent()}, "no recorded episodes"),
    ],
)
def test_loading_broken_and_empty_files_are_told_in_words(opened, words):
    view = project(watching(), World(shelf=(ShelfItem(FILE, "one"),), opened=opened))
    assert words in view.notice
    assert not view.transport.is_enabled


def test_each_state_of_a_run_is_told_in_words():
    for status in RunStatus:
        view = project(Session(source=None), world(RunUpdate(status, message="why")))
        assert view.status
        assert view.notice


def test_a_saved_agent_of_the_other_preset_is_shown_as_well():
    agent = saved_agent(config=PaperConfig())
    view = project(watching(), World(opened={FILE: agent}))
    assert view.forest is agent.forest_view()


def test_the_form_follows_the_task_of_a_file_that_was_opened_and_then_leaves_it():
    w = replace(world(), env_ids=("Pendulum-v1", "CartPole-v1"))
    opened = advance(watching(form=Form(env="Pendulum-v1")), w, 0.05)
    assert opened.form.env == "CartPole-v1"
    edited = replace(opened, form=replace(opened.form, env="Pendulum-v1"))
    assert advance(edited, w, 0.05).form.env == "Pendulum-v1"
    unlisted = advance(watching(), replace(w, env_ids=("Pendulum-v1",)), 0.05)
    assert unlisted.form.env == OTHER_ENV
    assert unlisted.form.env_id == "CartPole-v1"
    assert advance(watching(source=None), w, 0.05).form == Form()


def test_what_was_folded_is_forgotten_with_another_agent():
    look = Look(folded=frozenset({1}), axes=(1, 2), coloring=Coloring.AGE, deepest=2)
    elsewhere = after(watching(look=look), ChooseSource(None))
    assert elsewhere.look == Look(coloring=Coloring.AGE, deepest=2)


def test_a_new_run_is_another_forest_where_nothing_is_selected_yet():
    before, now = RunUpdate(run_id=1), RunUpdate(run_id=2)
    chosen = Session(selected=3, opened=1, trail=(Place(3, 1),), trail_at=0)
    fresh = follow(chosen, before, now)
    assert (fresh.selected, fresh.opened, fresh.trail) == (NO_OPTION, None, ())
    assert follow(chosen, before, replace(before, n_steps=9)) == chosen
    elsewhere = replace(chosen, source=FILE)
    assert follow(elsewhere, before, now) == elsewhere
