"""Agents to export: a shipped one, and one whose every name wants to do harm."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from ao2viz import export
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

Export = Callable[..., Path]


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


@pytest.fixture(scope="session")
def cartpole() -> SavedAgent:
    """The shipped agent with the first 40 steps of each of its two episodes."""
    saved = read(saved_schemas() / "CartPole-v1.ao2")
    return replace(saved, episodes=tuple(first_steps(e, 40) for e in saved.episodes))


@pytest.fixture(scope="session")
def pendulum() -> SavedAgent:
    saved = read(saved_schemas() / "Pendulum-v1.ao2")
    return replace(saved, episodes=tuple(first_steps(e, 40) for e in saved.episodes))


@pytest.fixture(scope="session")
def hostile(cartpole: SavedAgent) -> SavedAgent:
    """The same agent with names that a stranger chose."""
    spec = replace(
        cartpole.spec,
        title=HOSTILE_TITLE,
        features=tuple(Feature(name, "<b>", 1.0) for name in HOSTILE),
        action_names=HOSTILE_ACTIONS,
        entry=Entry("CartPole-v1", HOSTILE_TITLE),
    )
    return replace(cartpole, spec=spec)


@pytest.fixture
def write(tmp_path: Path) -> Export:
    """Exports into a fresh file and says where it is."""

    def run(agent: SavedAgent, format: str, **chosen) -> Path:
        return export(agent, tmp_path / f"out-{format}", format, **chosen)

    return run
