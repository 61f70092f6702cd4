"""What commands about the replay change in a session; pure.

These are the cases of `reduce` that move through an episode, hold it, and let it go otherwise.
"""

from dataclasses import replace
from functools import lru_cache
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.conditions import Condition, meets
from ao2viz.explain.moments import find_moments
from ao2viz.explain.typed_conditions import ConditionError, parse_condition
from ao2viz.explain.words import count
from ao2viz.recording.episode import Episode
from ao2viz.training.branching import Takeover
from ao2viz.ui.branches import Branch, BranchFailure, BranchWish
from ao2viz.ui.commands import Move, Seek, Transport
from ao2viz.ui.replay_commands import (
    CancelBranch,
    LimitBranch,
    LookAround,
    LookBack,
    Rejoin,
    ReplayCommand,
    SeekMoment,
    SeekStop,
    SetLoop,
    SetPlaySpeed,
    SetStop,
    ShowMoment,
    TakeOver,
)
from ao2viz.ui.session import Session
from ao2viz.ui.watched import agent_of, config_of, episode_of, learned_of, past_of, spec_of
from ao2viz.ui.world import LoadFailure, World

STEPS_PER_S = 10.0
"""How fast a recorded episode plays at speed 1."""

MAX_BRANCH_LIMIT = 10_000
_GLANCES = 50  # So many glances lead from an agent's beginning to now.

Replaying = Move | Seek | ReplayCommand
"""The commands that this file knows."""


def steer(session: Session, command: Replaying, world: World) -> Session:
    """The session after a command."""
    session = replace(session, remark="")
    match command:
        case Move(to):
            return _move(session, to, world)
        case Seek(step):
            return hold_at(session, step, world)
        case ShowMoment(number, step):
            return hold_at(replace(leave_branch(session), episode=max(0, number)), step, world)
        case SetPlaySpeed(factor):
            return replace(session, play_speed=factor)
        case SetLoop(is_on):
            return replace(session, loops=not session.loops if is_on is None else is_on)
        case SeekMoment(is_forward):
            return _seek_moment(session, is_forward, world)
        case SetStop(text):
            return _set_stop(session, text, world)
        case SeekStop(is_forward):
            return _seek_stop(session, is_forward, world)
        case TakeOver(action):
            return _take_over(session, action, world)
        case LimitBranch(steps):
            return replace(session, branch_limit=int(np.clip(steps, 0, MAX_BRANCH_LIMIT)))
        case CancelBranch():
            return replace(session, wish=None)
        case Rejoin():
            if session.branch is None:
                return replace(session, remark="This is the main line.")
            return replace(
                leave_branch(session), position=float(session.branch.departure), is_playing=False
            )
        case LookBack(step):
            return _look_back(session, step, world)
        case LookAround(is_forward):
            return _look_around(session, is_forward, world)
        case _:
            assert_never(command)


def play_on(session: Session, world: World, seconds: float) -> Session:
    """Lets a playing episode go on: it holds at its end, or where the condition is met."""
    session = _go_where_wanted(_follow_wish(session, world), world)
    if not session.is_playing or episode_of(session, world) is None:
        return session
    last = last_position(session, world)
    position = session.position + seconds * STEPS_PER_S * session.play_speed
    stops = np.flatnonzero(find_stops(session, world))
    held = stops[(stops > int(session.position)) & (stops <= int(position))]
    if len(held):
        words = f"Held at step {held[0]:,}: {session.stop_text}."
        return replace(session, position=float(held[0]), is_playing=False, remark=words)
    if position < last:
        return replace(session, position=position)
    if session.loops and session.position >= last:  # The end was shown; now the beginning.
        return replace(session, position=0.0)
    return replace(session, position=float(last), is_playing=session.loops)


def last_position(session: Session, world: World) -> int:
    """One past the last step: there the episode's end is shown."""
    episode = episode_of(session, world)
    return 0 if episode is None else len(episode)


def leave_branch(session: Session) -> Session:
    """Back on the main line; what was being played is called off."""
    return replace(session, branch=None, wish=None)


def hold_at(session: Session, step: int, world: World) -> Session:
    """Shows a step, or the nearest that there is."""
    held = float(np.clip(step, 0, last_position(session, world)))
    return replace(session, position=held, is_playing=False)


def find_stops(session: Session, world: World) -> NDArray[np.bool_]:
    """[T] the steps of what is watched at which playing holds."""
    episode, spec = episode_of(session, world), spec_of(session, world)
    if not session.stop_text or episode is None or spec is None:
        return np.empty(0, np.bool_)
    try:
        condition = _parsed(session.stop_text, spec)
    except ConditionError:  # It was about another task.
        return np.empty(0, np.bool_)
    return meets(condition, episode, spec, config_of(session, world))


@lru_cache(maxsize=64)
def _parsed(text: str, spec: TaskSpec) -> Condition:
    return parse_condition(text, spec)


def _move(session: Session, to: Transport, world: World) -> Session:
    last, at = last_position(session, world), int(session.position)
    match to:
        case Transport.FIRST:
            return replace(session, position=0.0, is_playing=False)
        case Transport.BACK:
            return replace(session, position=float(max(0, at - 1)), is_playing=False)
        case Transport.FORWARD:
            return replace(session, position=float(min(last, at + 1)), is_playing=False)
        case Transport.LAST:
            return replace(session, position=float(last), is_playing=False)
        case Transport.PLAY:
            again = session.position >= last and not session.is_playing
            position = 0.0 if again else session.position
            return replace(session, position=position, is_playing=not session.is_playing)
        case _:
            assert_never(to)


def _seek(session: Session, steps: NDArray[np.int64], is_forward: bool, what: str) -> Session:
    at = int(session.position)
    found = steps[steps > at][:1] if is_forward else steps[steps < at][-1:]
    if len(found) == 0:
        way = "after" if is_forward else "before"
        return replace(session, is_playing=False, remark=f"There is no {what} {way} step {at:,}.")
    return replace(session, position=float(found[0]), is_playing=False)


def _seek_moment(session: Session, is_forward: bool, world: World) -> Session:
    episode = episode_of(session, world)
    if episode is None:
        return session
    moments = find_moments(episode, config_of(session, world))
    steps = np.unique([moment.step for moment in moments])
    return _seek(session, steps, is_forward, "moment of note")


def _set_stop(session: Session, text: str, world: World) -> Session:
    spec, text = spec_of(session, world), text.strip()
    if text and spec is not None:
        try:
            _parsed(text, spec)
        except ConditionError as error:
            return replace(session, stop_problem=str(error))
    return replace(session, stop_text=text, stop_problem="")


def _seek_stop(session: Session, is_forward: bool, world: World) -> Session:
    if not session.stop_text:
        return replace(session, remark="Type a condition first, for example: margin < 0.1")
    stops = np.flatnonzero(find_stops(session, world))
    return _seek(session, stops, is_forward, f"step with {session.stop_text}")


def _take_over(session: Session, action: int, world: World) -> Session:
    episode, spec = episode_of(session, world), spec_of(session, world)
    learned = learned_of(session, world)
    if episode is None or spec is None or learned is None:
        return replace(session, remark="Pause first, or watch a recorded episode.")
    step = int(session.position)
    if step >= len(episode):
        return replace(session, remark="The episode has ended here; go back to one of its steps.")
    if not 0 <= action < spec.n_actions:
        return replace(session, remark=f"There is no action {action}.")
    main, before = episode, ()
    if session.branch is not None:
        main = session.branch.main
        before = tuple(t for t in session.branch.takeovers if t.step < step)
    takeovers = (*before, Takeover(step, action))
    wish = BranchWish(main, spec, learned, takeovers, session.branch_limit)
    return replace(session, wish=wish, is_playing=False)


def _follow_wish(session: Session, world: World) -> Session:
    """Shows a branch once it has been played, at the step that a person took over."""
    if session.wish is None:
        return session
    wish, result = session.wish, world.branched.get(session.wish)
    if isinstance(result, BranchFailure):
        return replace(session, wish=None, remark=result.message)
    if not isinstance(result, Episode):
        return session
    branch = Branch(wish.main, wish.takeovers, result)
    return replace(
        session,
        wish=None,
        branch=branch,
        position=float(wish.takeovers[-1].step),
        is_playing=False,
    )


def _go_where_wanted(session: Session, world: World) -> Session:
    """Goes to the moment that an address asked for, once its file is open."""
    wanted = session.wanted
    if wanted is None or session.source is None:
        return session
    if isinstance(world.opened.get(session.source), LoadFailure):
        return replace(session, wanted=None)
    agent = agent_of(session, world)
    if agent is None:
        return session
    session = replace(session, wanted=None, is_playing=False)
    episode, n = wanted.episode or 0, len(agent.episodes)
    if episode >= n:
        known = f"only episodes 0 to {n - 1}, counted from 0" if n else "no recorded episodes"
        words = f"You asked for episode {episode:,}, but this agent has {known}."
        return replace(session, remark=words)
    session = replace(session, episode=episode, is_playing=wanted.step is None)
    if wanted.step is None:
        return session
    session = hold_at(session, wanted.step, world)
    steps = len(agent.episodes[episode])
    if wanted.step > steps:
        words = f"You asked for step {wanted.step:,}, but this episode has {count(steps, 'step')}."
        return replace(session, remark=words)
    return session


def _look_back(session: Session, step: int | None, world: World) -> Session:
    past = past_of(session, world)
    if step is None or past is None:
        return replace(session, looks_back=None)
    held = max(0, step)
    return replace(session, looks_back=held if held < past.n_steps else None)


def _look_around(session: Session, is_forward: bool, world: World) -> Session:
    past = past_of(session, world)
    if past is None:
        return replace(session, remark="Of this forest's past nothing is known.")
    at = past.n_steps if session.looks_back is None else session.looks_back
    stride = max(1, past.n_steps // _GLANCES)
    return _look_back(session, at + stride if is_forward else at - stride, world)
