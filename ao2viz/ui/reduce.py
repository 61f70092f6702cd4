"""What a command changes in one browser's session, and what it asks of the rest; pure."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import assert_never

from ao2viz.core.config import Preset
from ao2viz.core.decision import NO_OPTION
from ao2viz.training.states import (
    Pause,
    Resume,
    RunCommand,
    RunEpisode,
    RunStatus,
    Save,
    SetDecideBy,
    SetSpeed,
    Start,
    Step,
    Stop,
    TrainOn,
    accepts,
)
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.again import learn_again
from ao2viz.ui.appearance import AppearanceCommand, Remember
from ao2viz.ui.appearing import appear
from ao2viz.ui.commands import (
    ChooseDecideBy,
    ChooseEpisode,
    ChooseOver,
    ChooseSmoothing,
    ChooseSource,
    Command,
    ConfirmOverwrite,
    Download,
    Edit,
    Field,
    FindState,
    LayBehind,
    Pick,
    Press,
    RunButton,
    SetTrainingSpeed,
    ShowAhead,
)
from ao2viz.ui.comparing import compare
from ao2viz.ui.dialog_commands import DialogCommand, NextStage
from ao2viz.ui.dialogs import attend, defaults_for
from ao2viz.ui.downloads import Notify, SaveFile, make_table
from ao2viz.ui.exploring import Exploring, choose_axes, explore, forget_place, say_found
from ao2viz.ui.exporting import take_away
from ao2viz.ui.jobs import Begin
from ao2viz.ui.learners import lay
from ao2viz.ui.places import make_link
from ao2viz.ui.questions import (
    CallOff,
    CompareCommand,
    ExportCommand,
    LearnAgainCommand,
    WhatIfCommand,
    WholeCommand,
)
from ao2viz.ui.replay_commands import ShowLink
from ao2viz.ui.replaying import Replaying, leave_branch, play_on, steer
from ao2viz.ui.session import OTHER_ENV, Form, Session
from ao2viz.ui.settings import find_overrides
from ao2viz.ui.shelf import NAME_RULE, ShelfEffect, path_for
from ao2viz.ui.walking import follow_step, walk_on
from ao2viz.ui.watched import agent_of, decision_of, forest_of, spec_of
from ao2viz.ui.what_if import suppose
from ao2viz.ui.whole import ask_whole
from ao2viz.ui.world import World


@dataclass(frozen=True)
class PickOption:
    """Asks which option a ray hits; the scene knows where they stand."""

    pick: Pick


Effect = RunCommand | Remember | ShelfEffect | PickOption | SaveFile | Begin | CallOff
Result = tuple[Session, tuple[Effect, ...]]


def reduce(session: Session, command: Command, world: World) -> Result:
    """The session after a command, and what has to happen outside of it."""
    if isinstance(command, NextStage):
        return walk_on(_watch(session, None, world), world)
    if isinstance(command, AppearanceCommand):
        return appear(session, command)
    if isinstance(command, DialogCommand):
        return attend(session, command, world)
    if isinstance(command, Replaying):
        return steer(session, command, world), ()
    if isinstance(command, WhatIfCommand):
        return suppose(session, command, world)
    if isinstance(command, CompareCommand):
        return compare(session, command, world)
    if isinstance(command, ExportCommand):
        return take_away(session, command, world)
    if isinstance(command, LearnAgainCommand):
        return learn_again(session, command, world)
    if isinstance(command, WholeCommand):
        return ask_whole(session, command, world)
    match command:
        case ChooseSource(path):
            return _watch(session, path, world), ()
        case ChooseEpisode(index):
            session = replace(leave_branch(session), remark="", wanted=None)
            return replace(session, episode=max(0, index), position=0.0, is_playing=True), ()
        case Pick():
            return session, (PickOption(command),)
        case Edit(field, value):
            return replace(session, form=_fill_in(session.form, field, value)), ()
        case Press(button):
            return _press(session, button, world)
        case ConfirmOverwrite(is_yes):
            return _answer(session, is_yes)
        case SetTrainingSpeed(steps_per_s):
            return session, (SetSpeed(steps_per_s),)
        case ChooseDecideBy(decide_by):
            return session, (SetDecideBy(decide_by),)
        case ChooseOver(over):
            return replace(session, charts=replace(session.charts, over=over)), ()
        case ChooseSmoothing(episodes):
            return replace(session, charts=replace(session.charts, smoothing=episodes)), ()
        case LayBehind():
            return lay(session, command, world), ()
        case ShowAhead(is_shown):
            wanted = not session.shows_ahead if is_shown is None else is_shown
            return replace(session, shows_ahead=wanted), ()
        case CallOff():
            return session, (command,)
        case Download(table):
            return session, (make_table(table, session, world),)
        case ShowLink():
            return session, (make_link(session, world),)
        case _:
            return _explore(session, command, world)


def advance(session: Session, world: World, seconds: float) -> Session:
    """Lets a playing episode go on; at its end it stays and stops."""
    session = _fill_in_task(session, world)
    look = choose_axes(session.look, forest_of(session, world))
    if look is not session.look:
        session = replace(session, look=look)
    return play_on(session, world, seconds)


def _fill_in_task(session: Session, world: World) -> Session:
    """Prepares the form for more training on the task of a file that has just been opened."""
    agent = agent_of(session, world)
    if agent is None or session.form_source == session.source:
        return session
    env_id, form = agent.spec.env_id, session.form
    if env_id in world.env_ids:
        form = replace(form, env=env_id, preset=agent.preset)
    else:
        form = replace(form, env=OTHER_ENV, custom_env=env_id, preset=agent.preset)
    return replace(session, form=form, form_source=session.source)


def follow(session: Session, before: RunUpdate, now: RunUpdate) -> Session:
    """Keeps a browser that watches the run at its latest step; a new run is another forest."""
    if session.source is None and now.learned is None:
        session = replace(session, looks_back=None)
    if session.source is None and now.run_id != before.run_id:
        session = _forget_options(session)
    session = follow_step(session, before, now)
    if session.source is not None or now.episode is before.episode:
        return session
    latest = max(0, len(now.episode) - 1) if now.episode is not None else 0
    return replace(leave_branch(session), position=float(latest), is_playing=False)


def _watch(session: Session, path: Path | None, world: World) -> Session:
    if path == session.source:
        return session
    session = replace(
        leave_branch(session),
        looks_back=None,
        remark="",
        wanted=None,
        source=path,
        episode=0,
        position=0.0,
        is_playing=path is not None,
        fits=session.fits + 1,
    )
    session = replace(_forget_options(session), supposition=None)
    if path is None and world.update.episode is not None:
        return replace(session, position=float(max(0, len(world.update.episode) - 1)))
    return session


def _explore(session: Session, command: Exploring, world: World) -> Result:
    forest, spec = forest_of(session, world), spec_of(session, world)
    decision = decision_of(session, world)
    session, problem = explore(session, command, forest, spec, decision)
    if problem:
        return session, (Notify("Not here", problem),)
    # Else only a ring says so, which may stand outside of the canvas.
    found = say_found(session, command.text, forest, spec) if isinstance(command, FindState) else ""
    return session, ((Notify("Found", found),) if found else ())


def _forget_options(session: Session) -> Session:
    """What was chosen among the options of one forest means nothing in another."""
    return replace(
        session,
        selected=NO_OPTION,
        opened=None,
        trail=(),
        trail_at=-1,
        look=forget_place(session.look),
    )


def _fill_in(form: Form, field: Field, value: str | int) -> Form:
    match field:
        case Field.ENV:
            return replace(form, env=str(value))
        case Field.CUSTOM_ENV:
            return replace(form, custom_env=str(value))
        case Field.PRESET:
            return replace(form, preset=Preset(value))
        case Field.SEED:
            return replace(form, seed=int(value))
        case Field.STEPS:
            return replace(form, steps=int(value))
        case Field.FILE_NAME:
            return replace(form, file_name=str(value))
        case _:
            assert_never(field)


def run_command(button: RunButton, session: Session, world: World) -> type[RunCommand] | None:
    """What a button asks of the run now, None if that cannot be; one button may ask two things."""
    kind = _asked(button, session, world.update.status)
    if button is RunButton.TRAIN_ON and kind is Start and agent_of(session, world) is None:
        return None  # The file is not open yet, or broken.
    return kind if accepts(world.update.status, kind) else None


def _asked(button: RunButton, session: Session, status: RunStatus) -> type[RunCommand]:
    match button:
        case RunButton.START:
            return Start
        case RunButton.TRAIN_ON:
            return TrainOn if session.source is None else Start
        case RunButton.PAUSE:
            return Pause if status is RunStatus.RUNNING else Resume
        case RunButton.STEP:
            return Step
        case RunButton.EPISODE:
            return RunEpisode
        case RunButton.STOP:
            return Stop
        case RunButton.SAVE:
            return Save
        case _:
            assert_never(button)


def _press(session: Session, button: RunButton, world: World) -> Result:
    kind = run_command(button, session, world)
    if kind is None:
        # Two browsers can press at once; the table decides and the second one is told.
        what = f"“{button.value}” does not fit: the run is {world.update.status.value}."
        return session, (Notify("Not now", what),)
    if kind is Save:
        return _save(session, world)
    if kind is TrainOn:
        return session, (TrainOn(session.form.steps),)
    if kind is not Start:
        return session, (kind(),)  # pyright: ignore[reportCallIssue]
    if button is RunButton.TRAIN_ON:
        return _train_on(session, world)
    form = session.form
    overrides, problem = find_overrides(form, defaults_for(form, world))
    problem = _what_is_missing(form) or problem
    if problem:
        return session, (Notify("Cannot start", problem, is_error=True),)
    start = Start(form.env_id, form.preset, form.seed, form.steps, overrides)
    return _watch(session, None, world), (start,)


def _train_on(session: Session, world: World) -> Result:
    """A run that begins with the agent of the file that is watched; the file stays as it is."""
    agent = agent_of(session, world)
    assert agent is not None
    env_id = agent.spec.env_id
    # What the dashboard was started with may say which module an environment comes from.
    known = (each for each in world.env_ids if each.rpartition(":")[2] == env_id)
    start = Start(
        next(known, env_id),
        agent.preset,
        agent.seed,
        session.form.steps,
        resume_from=session.source,
    )
    return _watch(session, None, world), (start,)


def _what_is_missing(form: Form) -> str:
    if not form.env_id:
        return "Type the Gymnasium id of an environment first, for example LunarLander-v3."
    if not form.may_be_made:
        return "An id with a colon imports code; start such an environment from the terminal."
    return ""


def _save(session: Session, world: World) -> Result:
    path = path_for(session.form.file_name, session, world)
    if path is None:
        return session, (Notify("Cannot save", NAME_RULE, is_error=True),)
    if path.exists():
        return replace(session, overwrite=path), ()
    return session, (Save(path),)


def _answer(session: Session, is_yes: bool) -> Result:
    path = session.overwrite
    session = replace(session, overwrite=None)
    return session, ((Save(path),) if is_yes and path is not None else ())
