"""The panel with the legend: what it says while there is no forest."""

from collections.abc import Iterator

import pytest
import viser

from ao2viz.training.states import RunStatus
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.inbox import Inbox
from ao2viz.ui.panels.legend import LegendPanel
from ao2viz.ui.security import make_server
from ao2viz.ui.session import Session
from ao2viz.ui.view import project
from ao2viz.ui.world import LoadFailure, World
from tests.ui.test_reduce import FILE


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    made = make_server("127.0.0.1", 0)
    yield made
    made.stop()


def test_nobody_is_asked_to_start_what_is_on_its_way(server) -> None:
    panel = LegendPanel(server.gui, 1, Inbox())
    ready = World(update=RunUpdate(RunStatus.PREPARING, run_id=1))
    broken = World(opened={FILE: LoadFailure("It is no agent.")})
    for source, world, words in (
        (None, World(), "Start grows one"),
        (None, ready, "on its way"),
        (FILE, World(), "on its way"),
        (FILE, broken, "Start grows one"),
    ):
        panel.sync(project(Session(source=source), world), None)
        assert words in panel._text.content
