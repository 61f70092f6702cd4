"""Below a decision: what is told only while nothing moves, and when the rest is counted."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
import viser

from ao2viz.training.states import RunStatus
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.panels.why import WhyPanel
from ao2viz.ui.security import make_server
from ao2viz.ui.session import Session
from ao2viz.ui.view import project
from ao2viz.ui.world import World
from tests.ui.test_reduce import FILE, episode, watching, world

WHEN = "Faithfulness is counted when the run is held"


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    made = make_server("127.0.0.1", 0)
    yield made
    made.stop()


def test_while_the_agent_learns_it_is_told_when_that_is_counted(server) -> None:
    why = WhyPanel(server.gui)
    saved, made = world().opened[FILE], episode(3)
    update = RunUpdate(RunStatus.RUNNING, spec=saved.spec, decision=made.decisions[1])
    running = project(Session(source=None), World(update=update))
    why.sync(running, "")
    assert WHEN in why._faithful.content
    why.sync(replace(running, decision=None), "")
    assert why._faithful.content == ""
    why.sync(running, "")
    why.sync(project(watching(), world()), "")  # A saved agent no longer changes.
    assert WHEN not in why._faithful.content


def test_why_not_another_action_is_told_when_nothing_moves(server) -> None:
    why = WhyPanel(server.gui)
    held = project(replace(watching(), is_playing=False, position=1.0), world())
    why.sync(held, "")
    assert "Why not another action" in why._why_not.content
    why.sync(project(replace(watching(), is_playing=True, position=1.0), world()), "")
    assert why._why_not.content == ""
    why.sync(held, "")
    assert "Why not another action" in why._why_not.content
    saved = world().opened[FILE]
    update = RunUpdate(
        RunStatus.RUNNING, spec=saved.spec, forest=saved.forest_view(), decision=held.decision
    )
    live = Session(source=None, is_playing=False)
    why.sync(project(live, World(update=update)), "")
    assert why._why_not.content == ""
