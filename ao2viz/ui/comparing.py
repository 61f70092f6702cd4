"""Which agent stands beside the one that is watched, and what is asked of the two; pure."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import assert_never

from ao2viz.core.mind import Mind
from ao2viz.envs.task import TaskSpec
from ao2viz.experiments.duel import Beside, Duel, fight, put_beside
from ao2viz.recording.episode import Episode
from ao2viz.store.saved import Learned, SavedAgent
from ao2viz.ui.downloads import Notify
from ao2viz.ui.jobs import Begin
from ao2viz.ui.questions import (
    ChooseDuelSeed,
    ChooseOther,
    CompareCommand,
    Fight,
    SeekDuel,
    Task,
)
from ao2viz.ui.session import Session
from ao2viz.ui.watched import learned_of, spec_of
from ao2viz.ui.world import LoadFailure, World

DUEL_EPISODES = 20
"""Both agents play so many episodes for their returns."""


@dataclass(frozen=True, eq=False)
class Other:
    """The agent beside the one that is watched."""

    path: Path
    agent: SavedAgent | None  # None: it cannot be compared; `words` say why.
    words: str
    seed: int
    step: int


def other_of(session: Session, world: World) -> Other | None:
    """What is compared with what is watched; None: nothing was chosen."""
    path = session.other
    if path is None:
        return None
    opened, spec = world.opened.get(path), spec_of(session, world)
    agent, words = None, f"Opening {path.name} …"
    if isinstance(opened, LoadFailure):
        words = opened.message
    elif isinstance(opened, SavedAgent) and spec is not None:
        words = _misfit(spec, opened.spec)
        agent = opened if not words else None
    return Other(path, agent, words, session.duel_seed, session.duel_step)


def _misfit(one: TaskSpec, other: TaskSpec) -> str:
    """Why two agents cannot be compared; empty if they can."""
    if one.n_features == other.n_features and one.action_names == other.action_names:
        return ""
    return (
        f"{other.env_id} does not fit {one.env_id}: it has {other.n_features} features and the "
        f"actions {', '.join(other.action_names)}. Choose an agent of the same task."
    )


def compare(
    session: Session, command: CompareCommand, world: World
) -> tuple[Session, tuple[Notify | Begin, ...]]:
    """The session after a command, and what has to happen outside of it."""
    match command:
        case ChooseOther(path):
            if path is not None and path not in {item.path for item in world.shelf}:
                return session, (Notify("Not here", "That file is no longer on the shelf."),)
            return replace(session, other=path, duel_step=0), ()
        case ChooseDuelSeed(seed):
            return replace(session, duel_seed=seed), ()
        case SeekDuel(step):
            return replace(session, duel_step=max(0, step)), ()
        case Fight():
            learned, spec = learned_of(session, world), spec_of(session, world)
            other = other_of(session, world)
            if learned is None or spec is None:
                held = "Hold the run first, or watch a saved agent."
                return session, (Notify("Not now", held),)
            if other is None or other.agent is None:
                words = other.words if other is not None else "Choose the other agent first."
                return session, (Notify("Not now", words),)
            work = _fight(learned, other.agent.learned, spec, session.duel_seed)
            begin = Begin(Task.DUEL, (learned, other.agent.learned), work)
            return replace(session, duel_step=0), (begin,)
        case _:
            assert_never(command)


def begin_beside(
    learned: Learned, episode: Episode | None, recorded: tuple[Episode, ...], agent: SavedAgent
) -> Begin:
    """The work of comparing what is watched with another agent, without playing."""

    def work(report: Callable[[Beside], bool]) -> Beside:
        del report
        one, other = (Mind(one.config, one.state) for one in (learned, agent.learned))
        return put_beside(one, other, episode, (recorded, agent.episodes))

    return Begin(Task.BESIDE, beside_subject(learned, episode, agent), work)


def beside_subject(
    learned: Learned, episode: Episode | None, agent: SavedAgent
) -> tuple[object, ...]:
    """What a comparison is about."""
    return learned, agent, episode


def _fight(
    learned: Learned, others: Learned, spec: TaskSpec, seed: int
) -> Callable[[Callable[[Duel], bool]], Duel]:
    def work(report: Callable[[Duel], bool]) -> Duel:
        one, other = (Mind(one.config, one.state) for one in (learned, others))
        return fight(one, other, spec, seed, DUEL_EPISODES, report)

    return work
