from collections.abc import Callable
from pathlib import Path

import pytest

from ao2viz import export
from ao2viz.store.saved import SavedAgent
from tests.exports import agents

Export = Callable[..., Path]


@pytest.fixture
def cartpole() -> SavedAgent:
    return agents.shipped("CartPole-v1")


@pytest.fixture
def pendulum() -> SavedAgent:
    return agents.shipped("Pendulum-v1")


@pytest.fixture
def hostile() -> SavedAgent:
    return agents.hostile()


@pytest.fixture
def tiny() -> SavedAgent:
    return agents.tiny()


@pytest.fixture
def write(tmp_path: Path) -> Export:
    """Exports into a fresh file and says where it is."""

    def run(agent: SavedAgent, format: str, **chosen) -> Path:
        return export(agent, tmp_path / f"out-{format}", format, **chosen)

    return run
