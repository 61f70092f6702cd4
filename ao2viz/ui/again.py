"""What only learning again can tell: an agent without an episode, a weight's rewards; pure."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, assert_never

from ao2viz.agent import AO2
from ao2viz.core.config import PaperConfig
from ao2viz.core.decision import NO_OPTION
from ao2viz.explain.forgetting import Forgotten
from ao2viz.explain.ledger import Account
from ao2viz.store.saved import SavedAgent
from ao2viz.training.relearning import LearningStoppedError
from ao2viz.ui.downloads import Notify
from ao2viz.ui.jobs import Begin, CalledOffError
from ao2viz.ui.questions import ChooseForgotten, Forget, KeepLedger, LearnAgainCommand, Task
from ao2viz.ui.session import Session
from ao2viz.ui.watched import agent_of
from ao2viz.ui.world import World

NOT_SAVED = "Learning again begins from a file: save the run, then choose the file under Watch."
NOTHING_LEARNED = "This agent has finished no training episode that could be forgotten."
NO_LEDGER = "Open a weight of an agent of the paper preset first: its weights are made of rewards."


@dataclass(frozen=True)
class Again:
    """What learning again could tell of what is watched."""

    agent: SavedAgent | None
    episode: int  # The training episode that would be forgotten.
    weight: tuple[int, int] | None  # Option and action whose rewards can be written down.
    problem: str  # Why no episode can be forgotten, in words; empty if one can.


def again_of(session: Session, world: World) -> Again:
    """What is chosen, and what can be asked."""
    agent = agent_of(session, world)
    if session.source is None or agent is None:
        return Again(None, session.forgotten, None, NOT_SAVED)
    last = len(agent.history) - 1
    weight = None
    if session.selected != NO_OPTION and session.opened is not None:
        is_alive = agent.forest_view().is_alive
        is_there = session.selected < len(is_alive) and is_alive[session.selected]
        if is_there and isinstance(agent.config, PaperConfig):
            weight = session.selected, session.opened
    problem = "" if last >= 0 else NOTHING_LEARNED
    return Again(agent, max(0, min(session.forgotten, last)), weight, problem)


def learn_again(
    session: Session, command: LearnAgainCommand, world: World
) -> tuple[Session, tuple[Notify | Begin, ...]]:
    """The session after a command, and what has to happen outside of it."""
    if isinstance(command, ChooseForgotten):
        return replace(session, forgotten=max(0, command.episode)), ()
    again = again_of(session, world)
    match command:
        case Forget():
            if again.agent is None or again.problem:
                return session, (Notify("Not here", again.problem),)
            begin = Begin(Task.FORGET, forget_subject(again), _forget(again.agent, again.episode))
        case KeepLedger():
            if again.agent is None or again.weight is None:
                return session, (Notify("Not here", NO_LEDGER),)
            begin = Begin(Task.LEDGER, ledger_subject(again), _account(again.agent, *again.weight))
        case _:
            assert_never(command)
    return session, (begin,)


def forget_subject(again: Again) -> tuple[object, ...]:
    """What forgetting is about."""
    return again.agent, again.episode


def ledger_subject(again: Again) -> tuple[object, ...]:
    """What a ledger is about."""
    return again.agent, again.weight


def _forget(saved: SavedAgent, episode: int) -> Callable[[Callable[[Any], bool]], Forgotten]:
    return _learning(saved, lambda agent, report: agent.explain.forget(episode, report))


def _account(
    saved: SavedAgent, option: int, action: int
) -> Callable[[Callable[[Any], bool]], Account]:
    return _learning(saved, lambda agent, report: agent.explain.ledger(option, action, report))


def _learning(
    saved: SavedAgent, ask: Callable[[AO2, Callable[[float], bool]], Any]
) -> Callable[[Callable[[Any], bool]], Any]:
    def work(report: Callable[[Any], bool]) -> Any:
        agent = AO2.from_saved(saved)  # With an environment of its own.
        try:
            return ask(agent, report)
        except LearningStoppedError:
            raise CalledOffError("Called off; nothing came of it.") from None

    return work
