"""Agents to export: two shipped ones, and one whose every name wants to do harm."""

import functools
from dataclasses import replace

from ao2viz.agent import AO2
from ao2viz.envs.catalogue import Entry, Feature
from ao2viz.recording.episode import Episode
from ao2viz.resources import saved_schemas
from ao2viz.store.files import read
from ao2viz.store.saved import SavedAgent

HOSTILE = (
    "<script>alert(1)</script>",
    '=HYPERLINK("http://evil.example","x")',
    "a | b `code` **bold** [link](http://evil.example) ![i](x) www.evil.example",
    r"\input{/etc/passwd} $x$ % & # _ { } ^ ~ \"quoted\"",
)
HOSTILE_ACTIONS = ("-cmd|' /C calc'!A0", '"];"a\\" -> b; </script><img src=x onerror=alert(1)>')
HOSTILE_TITLE = "@SUM(1)</title><svg/onload=alert(1)>&copy;"


def first_steps(episode: Episode, count: int) -> Episode:
    """The beginning of an episode, still under way."""
    return replace(
        episode,
        observations=episode.observations[: count + 1],
        actions=episode.actions[:count],
        rewards=episode.rewards[:count],
        decisions=episode.decisions[:count],
        terminated=False,
        truncated=False,
    )


@functools.cache
def shipped(env_id: str) -> SavedAgent:
    """The shipped agent with the first 40 steps of each of its two episodes."""
    saved = read(saved_schemas() / f"{env_id}.ao2")
    return replace(saved, episodes=tuple(first_steps(e, 40) for e in saved.episodes))


@functools.cache
def tiny() -> SavedAgent:
    """An agent that has hardly learned, with hostile names: some dozens of options."""
    agent = AO2("CartPole-v1", seed=0).learn(320)
    agent.record_episode(1)
    return with_hostile_names(agent.to_saved())


def hostile() -> SavedAgent:
    """The shipped CartPole agent with names that a stranger chose."""
    return with_hostile_names(shipped("CartPole-v1"))


def with_hostile_names(saved: SavedAgent) -> SavedAgent:
    """The same CartPole agent with names that a stranger chose."""
    spec = replace(
        saved.spec,
        title=HOSTILE_TITLE,
        features=tuple(Feature(name, "<b>", 1.0) for name in HOSTILE),
        action_names=HOSTILE_ACTIONS,
        entry=Entry("CartPole-v1", HOSTILE_TITLE),
    )
    return replace(saved, spec=spec)
