"""The agent that is watched as a whole: what is asked of it, and what has been counted."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, assert_never

import numpy as np

from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import ranges_by_id
from ao2viz.envs.task import TaskSpec, make_env
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.whole import Attended, Carriers, Coverage, Highlight, Roles
from ao2viz.recording.episode import Episode
from ao2viz.store.saved import Learned
from ao2viz.training.states import RunStatus
from ao2viz.ui.downloads import Notify
from ao2viz.ui.jobs import Begin, Jobs, JobState
from ao2viz.ui.questions import (
    ChooseMuted,
    ChooseMutedEpisodes,
    LookAtWhole,
    Mute,
    Task,
    WholeCommand,
)
from ao2viz.ui.session import Session
from ao2viz.ui.watched import forest_of, learned_of, recorded_in, spec_of
from ao2viz.ui.world import LoadFailure, World
from ao2viz.whole import WholeAgent

MOST_MUTED, MOST_EPISODES = 100, 1000
"""No more options are muted, and no more episodes played for each."""

_SEED = 0  # The same episodes as those of the command line, unless it is told another seed.
_KEPT = 16  # Answers that a browser keeps, the latest.
_ROLES_SHARE = 0.3  # Of the time that all takes, roughly; the rest is for faithfulness.
_CHANGES = "The agent changes with every step while it learns. Pause the run to look at it as a "
_NOBODY = "There is no agent yet. Start a run and pause it, or watch a saved agent."
_EMPTY = "It has no options yet: there is nothing to count."
_NO_OPTIONS = "Look at the whole agent first: it tells which options decide most often."


@dataclass(frozen=True, eq=False)
class Whole:
    """What can be asked of the whole agent that is watched."""

    subject: tuple[object, ...]  # What answers are about; empty if nothing can be asked.
    problem: str  # Why nothing can be asked, in words; empty if something can.
    states: int  # At which decisions were recorded; living options if there are none.
    are_recorded: bool
    beside: str  # The other agent on the page, which this is not about; empty: none.
    options: int  # So many would be muted,
    episodes: int  # and so many episodes played without each.
    looks: int  # Raised to ask for it to be seen.


@dataclass(frozen=True, eq=False)
class Portrait:
    """What has been counted by now of a whole agent; None: not yet."""

    attention: Attended | None = None
    coverage: Coverage | None = None
    highlights: tuple[Highlight, ...] | None = None
    roles: Roles | None = None
    faithfulness: Faithfulness | None = None
    share: float = 0.0  # Of the work that is done.
    is_complete: bool = False


@dataclass(frozen=True, eq=False)
class Playing:
    """How far playing without some options has come."""

    played: int  # Episodes,
    planned: int  # of so many.
    told: Carriers | None  # None: without none of them all episodes were played.


def whole_of(session: Session, world: World) -> Whole:
    """What can be asked of what is watched."""
    learned, recorded = learned_of(session, world), recorded_in(session, world)
    forest = forest_of(session, world)
    problem = _why_not(session, world)
    decisions = sum(len(episode) for episode in recorded)
    options = int(np.count_nonzero(forest.is_alive)) if forest is not None else 0
    if not problem and options == 0:
        problem = _EMPTY
    return Whole(
        subject=() if problem else (learned, *recorded),
        problem=problem,
        states=decisions or options,
        are_recorded=decisions > 0,
        beside=session.other.stem if session.other is not None else "",
        options=session.muted,
        episodes=session.muted_episodes,
        looks=session.looks_at_whole,
    )


def _why_not(session: Session, world: World) -> str:
    if learned_of(session, world) is not None:
        return ""
    if session.source is not None:
        opened = world.opened.get(session.source)
        is_broken = isinstance(opened, LoadFailure)
        return opened.message if is_broken else f"Opening {session.source.name} …"
    is_moving = world.update.status in (RunStatus.RUNNING, RunStatus.PREPARING)
    return f"{_CHANGES}whole." if is_moving else _NOBODY


def ask_whole(
    session: Session, command: WholeCommand, world: World
) -> tuple[Session, tuple[Notify | Begin, ...]]:
    """The session after a command, and what has to happen outside of it."""
    match command:
        case ChooseMuted(options):
            return replace(session, muted=int(np.clip(options, 1, MOST_MUTED))), ()
        case ChooseMutedEpisodes(episodes):
            kept = int(np.clip(episodes, 1, MOST_EPISODES))
            return replace(session, muted_episodes=kept), ()
        case LookAtWhole(begins):
            session = replace(session, looks_at_whole=session.looks_at_whole + 1)
            if not begins:
                return session, ()
        case Mute():
            pass
        case _:
            assert_never(command)
    whole, learned, spec = whole_of(session, world), learned_of(session, world), None
    if learned is not None:
        spec = spec_of(session, world)
    if whole.problem or learned is None or spec is None:
        return session, (Notify("Not now", whole.problem),)
    recorded = recorded_in(session, world)
    if isinstance(command, LookAtWhole):
        return session, (Begin(Task.WHOLE, whole.subject, _look(learned, spec, recorded)),)
    is_alive = learned.state["is_alive"]
    options = [one for one in command.options if 0 <= one < len(is_alive) and is_alive[one]]
    if not options:
        return session, (Notify("Not now", _NO_OPTIONS),)
    work = _play(learned, spec, recorded, options[:MOST_MUTED], session.muted_episodes)
    return session, (Begin(Task.MUTE, whole.subject, work),)


def _look(
    learned: Learned, spec: TaskSpec, recorded: tuple[Episode, ...]
) -> Callable[[Callable[[Portrait], bool]], Portrait]:
    def work(report: Callable[[Portrait], bool]) -> Portrait:
        whole = _whole_agent(learned, spec, recorded, partial(make_env, spec.env_id))
        known = Portrait(attention=whole.attention(), coverage=whole.coverage())
        known = replace(known, highlights=whole.highlights())
        roles = whole.roles(lambda share: report(replace(known, share=_ROLES_SHARE * share)))
        known = replace(known, roles=roles, share=_ROLES_SHARE)
        if not report(known):
            return known
        rest, is_wanted = 1.0 - _ROLES_SHARE, True

        def on_progress(share: float) -> bool:
            nonlocal is_wanted
            is_wanted = report(replace(known, share=_ROLES_SHARE + rest * share))
            return is_wanted

        told = whole.faithfulness(on_progress)
        return replace(known, faithfulness=told, share=1.0, is_complete=is_wanted)

    return work


def _play(
    learned: Learned,
    spec: TaskSpec,
    recorded: tuple[Episode, ...],
    options: list[int],
    episodes: int,
) -> Callable[[Callable[[Playing], bool]], Playing]:
    def work(report: Callable[[Playing], bool]) -> Playing:
        known = Playing(0, episodes * (len(options) + 1), None)

        def on_episode(played: int) -> bool:
            nonlocal known
            known = replace(known, played=played)
            return report(known)

        def on_progress(told: Carriers) -> bool:
            nonlocal known
            known = replace(known, told=told)
            return report(known)

        env = make_env(spec.env_id)
        try:
            whole = _whole_agent(learned, spec, recorded, lambda: env)
            told = whole.carriers(options, episodes, _SEED, on_progress, on_episode)
        finally:
            env.close()
        return replace(known, told=told)

    return work


def _whole_agent(
    learned: Learned, spec: TaskSpec, recorded: tuple[Episode, ...], get_env: Callable[[], Any]
) -> WholeAgent:
    mind = Mind(learned.config, learned.state)  # The work's own, for its thread.
    ranges = partial(ranges_by_id, spec.env_id, spec.n_features)
    return WholeAgent(mind, spec, recorded, get_env, ranges)


class Kept:
    """The answers about the agents that one browser watched: coming back to one asks nothing."""

    def __init__(self) -> None:
        # By ids, each beside what has it, so that it stands for one thing as long as it is kept.
        self._known: OrderedDict[tuple[object, ...], tuple[tuple[object, ...], JobState]] = (
            OrderedDict()
        )

    def look(self, jobs: Jobs, task: Task, subject: tuple[object, ...]) -> JobState | None:
        """How far work about this has come, or had come when another agent was watched instead."""
        if not subject:
            return None
        key = (task, *map(id, subject))
        job = jobs.look(task, subject)
        if job is None:
            known = self._known.get(key)
            return None if known is None else replace(known[1], is_done=True)
        self._known[key] = subject, job
        self._known.move_to_end(key)
        while len(self._known) > _KEPT:
            self._known.popitem(last=False)
        return job
