"""What a session watches, found in the world; pure."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config
from ao2viz.core.decision import Decision
from ao2viz.core.forest import ForestView
from ao2viz.core.mind import state_of
from ao2viz.envs.task import TaskSpec
from ao2viz.recording.episode import Episode
from ao2viz.recording.past import Moment, Past, make_past
from ao2viz.store.saved import Learned, SavedAgent
from ao2viz.training.states import RunStatus
from ao2viz.ui.session import Session
from ao2viz.ui.world import World


def agent_of(session: Session, world: World) -> SavedAgent | None:
    """The saved agent that is watched, once it is open."""
    opened = world.opened.get(session.source) if session.source is not None else None
    return opened if isinstance(opened, SavedAgent) else None


def agent_at_rest(session: Session, world: World) -> SavedAgent | None:
    """The agent that is watched, a held run's as well, with the episodes that can be gone to."""
    if session.source is not None:
        return agent_of(session, world)
    update = world.update
    return None if update.saved is None else _with_episode(update.saved, update.episode)


@lru_cache(maxsize=1)
def _with_episode(saved: SavedAgent, episode: Episode | None) -> SavedAgent:
    return replace(saved, episodes=() if episode is None else (episode,))


def episode_of(session: Session, world: World) -> Episode | None:
    """The episode that the transport moves through, a branch included; None while there is none."""
    if session.branch is not None:
        return session.branch.episode
    return main_line_of(session, world)


def main_line_of(session: Session, world: World) -> Episode | None:
    """The episode as it was recorded; None while there is none."""
    if session.source is None:
        return world.update.episode
    agent = agent_of(session, world)
    if agent is None or not agent.episodes:
        return None
    return agent.episodes[min(session.episode, len(agent.episodes) - 1)]


def forest_of(session: Session, world: World) -> ForestView | None:
    """The forest that is watched, if there is one."""
    if session.source is None:
        return world.update.forest
    agent = agent_of(session, world)
    return agent.forest_view() if agent is not None else None


def spec_of(session: Session, world: World) -> TaskSpec | None:
    """The task of what is watched."""
    agent = agent_of(session, world)
    return world.update.spec if session.source is None else agent.spec if agent else None


def decision_of(session: Session, world: World) -> Decision | None:
    """The decision at the place of the session; None past the end and before the first."""
    if session.source is None and world.update.status in (
        RunStatus.RUNNING,
        RunStatus.PREPARING,
    ):
        return world.update.decision
    episode = episode_of(session, world)
    if episode is None:
        return world.update.decision if session.source is None else None
    position = min(int(session.position), len(episode))
    return episode.decisions[position] if position < len(episode) else None


def observation_of(session: Session, world: World) -> NDArray[np.float64] | None:
    """What is seen [D] at the place of the session, past the last step as well."""
    decision, episode = decision_of(session, world), episode_of(session, world)
    if decision is not None:
        return decision.observation
    is_moving = world.update.status in (RunStatus.RUNNING, RunStatus.PREPARING)
    if episode is None or (session.source is None and is_moving):
        return None
    return episode.observations[min(int(session.position), len(episode))]


def recorded_in(session: Session, world: World) -> tuple[Episode, ...]:
    """The episodes that can be gone to."""
    agent = agent_of(session, world)
    if agent is not None:
        return agent.episodes
    episode = main_line_of(session, world)
    return (episode,) if episode is not None else ()


def config_of(session: Session, world: World) -> Config | None:
    """The settings of what is watched; None while they are not known."""
    learned = learned_of(session, world)
    return learned.config if learned is not None else None


def learned_of(session: Session, world: World) -> Learned | None:
    """What it has learned; None while a run goes on, for then that changes all the time."""
    if session.source is None:
        return world.update.learned
    agent = agent_of(session, world)
    return agent.learned if agent is not None else None


def history_of(session: Session, world: World) -> NDArray[np.float64]:
    """Its training episodes, [E, 4] as in `History`."""
    if session.source is None:
        return world.update.history
    agent = agent_of(session, world)
    return agent.history if agent is not None else np.empty((0, 4))


def past_of(session: Session, world: World) -> Past | None:
    """How its forest came to be; None while a run goes on, or if that is not known in full."""
    learned, forest = learned_of(session, world), forest_of(session, world)
    agent = agent_of(session, world)
    n_steps = agent.n_steps if agent is not None else world.update.n_steps
    return None if learned is None or forest is None else _past(learned, forest, n_steps)


@lru_cache(maxsize=4)
def _past(learned: Learned, forest: ForestView, n_steps: int) -> Past | None:
    try:
        past = make_past(forest, n_steps, learned.growth, learned.growth_dropped)
    except (ValueError, KeyError):  # The log does not belong to this forest.
        return None
    return past if past.is_whole else None


@lru_cache(maxsize=4)
def moment_at(past: Past, step: int) -> Moment | None:
    """The forest after a step; None where the log tells of something that is none."""
    try:
        return past.at(step)
    except ValueError:
        return None


@lru_cache(maxsize=4)
def learned_at(past: Past, step: int, config: Config) -> Learned:
    """What was known when a snapshot was taken: enough to decide as the agent did then."""
    return Learned(config, state_of(past.at(step).view), {}, 0)
