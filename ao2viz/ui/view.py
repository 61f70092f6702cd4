"""What one browser shows at one moment, worked out from its session and the world; pure."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config
from ao2viz.core.decision import Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.moments import Moment, find_moments
from ao2viz.explain.words import count, number
from ao2viz.recording.episode import Episode
from ao2viz.recording.past import Moment as PastMoment
from ao2viz.recording.past import Past
from ao2viz.store.saved import Learned
from ao2viz.training.states import RunStatus, SetDecideBy, accepts
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.again import Again, again_of
from ao2viz.ui.appearance import Appearance
from ao2viz.ui.branches import Branch, BranchUnderWay
from ao2viz.ui.commands import RunButton, Table
from ao2viz.ui.comparing import Other, other_of
from ao2viz.ui.dialog_commands import Dialog
from ao2viz.ui.dialogs import defaults_for
from ao2viz.ui.downloads import tables_of
from ao2viz.ui.exporting import Export, export_of
from ao2viz.ui.learners import Learners, learners_of
from ao2viz.ui.look import ChartLook, Look
from ao2viz.ui.places import command_to, link_to
from ao2viz.ui.reduce import run_command
from ao2viz.ui.replaying import find_stops
from ao2viz.ui.session import Form, Session
from ao2viz.ui.settings import SettingRow, setting_rows
from ao2viz.ui.shelf import folder_for
from ao2viz.ui.walking import Walk, can_walk, walk_of
from ao2viz.ui.watched import (
    agent_of,
    config_of,
    decision_of,
    episode_of,
    forest_of,
    history_of,
    learned_of,
    moment_at,
    observation_of,
    past_of,
    recorded_in,
    spec_of,
)
from ao2viz.ui.what_if import state_of
from ao2viz.ui.whole import Whole, whole_of
from ao2viz.ui.world import LoadFailure, ShelfItem, World

ForestKey = tuple[str, str, int]
"""Tells forests apart: where it comes from, and how often it was tidied up."""


_RECENT = 20  # Training episodes whose mean return tells how good an agent was.
_SEEN = 40  # States before this moment that are shown as well.


@dataclass(frozen=True)
class Transport:
    """The state of the transport."""

    position: int = 0
    last: int = 0
    is_playing: bool = False
    is_enabled: bool = False
    speed: float = 1.0


@dataclass(frozen=True, eq=False)
class Replay:
    """What the panels about the replay show beside the transport."""

    loops: bool
    moments: tuple[Moment, ...]
    stop_text: str
    stop_problem: str
    n_stops: int  # Steps that meet the condition.
    remark: str
    branch: Branch | None
    branching: BranchUnderWay | None  # None: none is being played.
    branch_limit: int
    can_take_over: bool
    link: str
    command: str


@dataclass(frozen=True, eq=False)
class Back:
    """The past moment that is shown in place of now."""

    past: Past
    moment: PastMoment
    returns: NDArray[np.float64]  # Of the latest up to 20 training episodes that had ended.


@dataclass(frozen=True, eq=False)
class View:
    """Everything one browser shows."""

    shelf: tuple[ShelfItem, ...]
    has_run: bool  # There is a training run to watch.
    source: Path | None
    episodes: tuple[str, ...]  # A label for each recorded episode.
    episode_index: int
    spec: TaskSpec | None
    forest: ForestView | None
    forest_key: ForestKey
    decision: Decision | None
    observation: NDArray[np.float64] | None  # What is seen at this moment.
    supposed: NDArray[np.float64] | None  # [D] what a person supposes instead; None: nothing.
    other: Other | None  # What is compared with what is watched.
    export: Export
    again: Again
    whole: Whole
    seen: NDArray[np.float64] | None  # [T, D] the last few states, this moment's at the end.
    episode: Episode | None
    frame: bytes | None  # The run's own picture; None: take the episode's.
    walk: Walk | None  # The stage of a single step that is shown.
    can_walk: bool  # There is a next stage.
    notice: str  # Said in place of a sentence while there is no decision.
    is_trouble: bool  # The notice tells what went wrong.
    transport: Transport
    replay: Replay
    n_lived: int  # Steps of training that can be looked back on; 0: none.
    back: Back | None  # None: now is shown.
    config: Config | None
    recorded: tuple[Episode, ...]  # Those that can be gone to.
    learned: Learned | None  # What can be asked of a whole mind; None while a run goes on.
    shows_ahead: bool
    selected: int
    opened: int | None  # The action whose weight is opened to its reasons.
    can_go_back: bool
    can_go_forward: bool
    look: Look
    run: RunUpdate
    enabled: frozenset[RunButton]
    can_choose_decide_by: bool
    status: str
    is_error: bool
    form: Form
    env_ids: tuple[str, ...]
    appearance: Appearance
    dialog: Dialog | None
    folders: tuple[Path, ...]  # Where agents may go.
    folder: Path  # Where they go.
    upload: Path | None  # The file that waits for a yes before it is replaced.
    settings: tuple[SettingRow, ...]  # Empty unless their dialog is open or one is typed.
    overwrite: Path | None
    history: NDArray[np.float64]
    seconds: NDArray[np.float64]  # [E] when its episodes ended; shorter or empty if not known.
    charts: ChartLook
    learners: Learners  # Of the paper's comparison, on the task that is watched.
    downloads: frozenset[Table]
    fits: int
    focuses: int
    selection_focuses: int


def project(session: Session, world: World) -> View:
    """Works out what a browser shows."""
    update = world.update
    is_run = session.source is None
    agent = agent_of(session, world)
    episode = episode_of(session, world)
    is_moving = is_run and update.status in (RunStatus.RUNNING, RunStatus.PREPARING)
    if is_moving:
        episode = None
    last = len(episode) if episode is not None else 0
    position = min(int(session.position), last)
    decision, spec = decision_of(session, world), spec_of(session, world)
    if episode is None:
        seen = decision.observation[None] if decision is not None else None
    else:
        seen = episode.observations[max(0, position - _SEEN) : position + 1]
    observation = observation_of(session, world)
    look = session.look
    shown = session.appearance
    axes = look.axes_for(spec.n_features if spec is not None else 0)
    look = replace(look, axes=axes, theme=shown.shown_theme, is_still=shown.rests)
    kind, name = ("run", str(update.run_id)) if is_run else ("file", str(session.source))
    return View(
        shelf=world.shelf,
        has_run=update.status is not RunStatus.IDLE or is_run,
        source=session.source,
        episodes=_episode_labels(agent.episodes if agent else ()),
        episode_index=session.episode,
        spec=spec,
        forest=forest_of(session, world),
        forest_key=(kind, name, session.tidies),
        decision=decision,
        observation=observation,
        supposed=state_of(session.supposition, observation),
        other=other_of(session, world),
        export=export_of(session, world),
        again=again_of(session, world),
        whole=whole_of(session, world),
        seen=seen,
        episode=episode,
        frame=update.frame if is_run and episode is None else None,
        walk=walk_of(session, world),
        can_walk=can_walk(session, world),
        notice=_notice(session, world, episode, position),
        is_trouble=_is_trouble(session, world),
        transport=Transport(
            position, last, session.is_playing, episode is not None, session.play_speed
        ),
        replay=_replay(session, world, episode, position),
        n_lived=_lived(session, world),
        back=_back(session, world),
        config=config_of(session, world),
        recorded=recorded_in(session, world),
        learned=learned_of(session, world),
        shows_ahead=session.shows_ahead,
        selected=session.selected,
        opened=session.opened,
        can_go_back=session.trail_at > 0,
        can_go_forward=session.trail_at + 1 < len(session.trail),
        look=look,
        run=update,
        enabled=frozenset(b for b in RunButton if run_command(b, session, world) is not None),
        can_choose_decide_by=accepts(update.status, SetDecideBy),
        status=_status(update),
        is_error=update.is_error,
        form=session.form,
        env_ids=world.env_ids,
        appearance=session.appearance,
        dialog=session.dialog,
        folders=world.folders,
        folder=folder_for(session, world),
        upload=session.upload.path if session.upload is not None else None,
        settings=_settings(session, world),
        overwrite=session.overwrite,
        history=history_of(session, world),
        seconds=update.seconds if is_run else np.empty(0),
        charts=session.charts,
        learners=learners_of(session, world),
        downloads=tables_of(session, world),
        fits=session.fits,
        focuses=session.focuses,
        selection_focuses=session.selection_focuses,
    )


def _settings(session: Session, world: World) -> tuple[SettingRow, ...]:
    if session.dialog is not Dialog.SETTINGS and not session.form.settings:
        return ()
    return setting_rows(session.form, defaults_for(session.form, world), world.update.config)


def _lived(session: Session, world: World) -> int:
    past = past_of(session, world)
    return past.n_steps if past is not None else 0


def _back(session: Session, world: World) -> Back | None:
    past = past_of(session, world)
    if past is None or session.looks_back is None or session.looks_back >= past.n_steps:
        return None
    moment = moment_at(past, session.looks_back)
    if moment is None:
        return None
    history = history_of(session, world)
    ended = history[history[:, 0] <= moment.step]
    return Back(past, moment, ended[-_RECENT:, 1])


def _replay(session: Session, world: World, episode: Episode | None, position: int) -> Replay:
    under_way = world.branched.get(session.wish) if session.wish is not None else None
    return Replay(
        loops=session.loops,
        moments=find_moments(episode, config_of(session, world)) if episode is not None else (),
        stop_text=session.stop_text,
        stop_problem=session.stop_problem,
        n_stops=int(np.count_nonzero(find_stops(session, world))),
        remark=session.remark,
        branch=session.branch,
        branching=under_way if isinstance(under_way, BranchUnderWay) else None,
        branch_limit=session.branch_limit,
        can_take_over=(
            episode is not None
            and position < len(episode)
            and learned_of(session, world) is not None
        ),
        link=link_to(session, world),
        command=command_to(session, world),
    )


def _episode_labels(episodes: tuple[Episode, ...]) -> tuple[str, ...]:
    return tuple(
        f"{i + 1}: return {number(e.total_reward)}, {count(len(e), 'step')}"
        f"{', while learning' if e.is_training else ''}"
        for i, e in enumerate(episodes)
    )


def _notice(session: Session, world: World, episode: Episode | None, position: int) -> str:
    """What to say where there is no decision to explain."""
    update = world.update
    if episode is not None and position == len(episode):
        return _ending(episode)
    if session.source is not None:
        opened = world.opened.get(session.source)
        if isinstance(opened, LoadFailure):
            return opened.message
        if opened is None:
            return f"Opening {session.source.name} …"
        if not opened.episodes:
            return "This agent has no recorded episodes. Its forest can be explored all the same."
        return ""
    match update.status:
        case RunStatus.IDLE:
            return "Nothing is being trained. Press Start on the right to grow a new forest."
        case RunStatus.PREPARING:
            return (
                "Getting ready: making the environment and compiling the agent. The first time on "
                "a computer this takes up to a minute."
            )
        case RunStatus.FAILED:
            return update.message
        case _:
            return "" if update.decision is not None else "Waiting for the first decision …"


def _is_trouble(session: Session, world: World) -> bool:
    if session.source is None:
        return world.update.status is RunStatus.FAILED
    return isinstance(world.opened.get(session.source), LoadFailure)


def _ending(episode: Episode) -> str:
    total = f"{count(len(episode), 'step')}, return {number(episode.total_reward)}."
    if episode.terminated:
        return f"End of the episode: the task itself ended. {total}"
    if episode.truncated:
        return f"End of the episode: its time limit was reached. {total}"
    return f"The latest step; the episode is still under way. {total}"


def _status(update: RunUpdate) -> str:
    """One line about the run."""
    match update.status:
        case RunStatus.IDLE:
            text = "No run yet."
        case RunStatus.PREPARING:
            text = "Getting ready …"
        case RunStatus.RUNNING:
            text = "Training."
        case RunStatus.PAUSED:
            text = "Paused."
        case RunStatus.FINISHED:
            text = "Finished."
        case RunStatus.FAILED:
            text = "Stopped by an error."
    if update.message.startswith(text.rstrip(". …")):
        return update.message
    return f"{text} {update.message}".strip()
