"""Agents to export: two shipped ones, and one whose every name wants to do harm."""

import functools
from collections.abc import Sequence
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

# As bad as a file can have them: up to 200 characters that can be printed.
WORST = (
    "</script><script>window.ran=1</script><svg onload=window.ran=1>&lt;b&gt;\u05d0\u0627",
    '\'"\\ \\" ${window.ran=1} {{7*7}} {0.__class__} %s %(x)s ]]> --> */ `x`  two  spaces ',
    "=cmd|'/C calc'!A0; @SUM(1) +1 -1 \\write18{touch x} \\end{longtable} $x$ & \\\\ %",
    ('"><img src=x onerror=window.ran=1>' * 9)[:200],
)
WORST_ACTIONS = ("javascript:window.ran=1//http://evil.example/x.png", WORST[3])
# As only a program can make them.
UNPRINTABLE = "a\nb\r\tc\x00\x1b[31m\u2028d\u2029\u202egnp.exe\u2066\ufeff\ud800\x7f e"


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
    return _named(saved, HOSTILE_TITLE, HOSTILE, "<b>", HOSTILE_ACTIONS)


@functools.cache
def brief() -> SavedAgent:
    """An agent with all that an export can be made of, and little of it: five steps."""
    saved = tiny()
    return replace(saved, episodes=(first_steps(saved.episodes[0], 5),))


def worst() -> SavedAgent:
    """The brief one with names as bad as a file can have them."""
    return _named(brief(), WORST[3], WORST, WORST[0], WORST_ACTIONS)


def unprintable() -> SavedAgent:
    """The brief one with names as only a program can make them."""
    names = [f"{i}{UNPRINTABLE}" for i in range(4)]
    return _named(brief(), UNPRINTABLE, names, UNPRINTABLE, names[:2])


def _named(
    saved: SavedAgent, title: str, features: Sequence[str], unit: str, actions: Sequence[str]
) -> SavedAgent:
    spec = replace(
        saved.spec,
        title=title,
        features=tuple(Feature(name, unit, 1.0) for name in features),
        action_names=tuple(actions),
        entry=Entry("CartPole-v1", title),
    )
    return replace(saved, spec=spec)
