"""Looking back on a forest: what is drawn and told of a past moment, and what is unknown of it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import viser

from ao2viz.core.growth import GrowthEvent, GrowthKind
from ao2viz.recording.growth_log import GrowthLog
from ao2viz.ui import html_past, html_replay
from ao2viz.ui.commands import ChooseSource, Command
from ao2viz.ui.gallery import Gallery
from ao2viz.ui.inbox import Inbox
from ao2viz.ui.jobs import Jobs
from ao2viz.ui.panels.inspect import InspectPanel
from ao2viz.ui.panels.legend import LegendPanel
from ao2viz.ui.panels.what_if import WhatIfPanel
from ao2viz.ui.panels.why import WhyPanel
from ao2viz.ui.replay_commands import (
    LookAround,
    LookBack,
)
from ao2viz.ui.security import make_server
from ao2viz.ui.thinker import Thinker
from ao2viz.ui.view import project
from ao2viz.ui.world import World
from tests.ui.test_reduce import FILE, after, watching, world


def lived(steps: int = 100) -> World:
    """A world whose agent made option 0 at step 10, and 1, 2, 3 and 4 each ten steps later."""
    taken = world()
    agent = taken.opened[FILE]
    log = GrowthLog()
    for n, parent in enumerate((-1, 0, 0, -1, 1)):
        log.extend([GrowthEvent(10 * (n + 1), GrowthKind.CREATED, n, parent)])
    history = np.array([[20.0, 5.0, 20.0, 2.0], [90.0, 7.0, 70.0, 5.0]])
    agent = replace(agent, growth=log.to_arrays(), n_steps=steps, history=history)  # pyright: ignore
    return replace(taken, opened={FILE: agent})


def test_the_past_is_what_had_been_made_by_then():
    life = lived()
    session = after(watching(3.0), LookBack(25), life)
    view = project(session, life)
    assert view.n_lived == 100
    assert view.back is not None
    assert np.flatnonzero(view.back.moment.view.is_alive).tolist() == [0, 1]
    assert view.back.returns.tolist() == [5.0]
    assert view.transport.position == 3  # The replay stays where it is.
    words = html_past.past_facts(view, None)
    assert "2 options stood then, 5 stand now." in words
    assert "arranged otherwise than now" in words
    assert "keeps no weights of the past, so only the structure is shown" in words
    assert "You are looking at step 25 of 100 of training." in html_past.canvas_line(view)
    assert "You are looking at step 25" in html_replay.line(view)


@pytest.mark.parametrize("command", [LookBack(None), LookBack(100), LookBack(10**9)])
def test_now_is_now(command: Command):
    life = lived()
    session = after(after(watching(), LookBack(25), life), command, life)
    assert session.looks_back is None
    view = project(session, life)
    assert view.back is None
    assert html_past.canvas_line(view) == ""


def test_glances_lead_from_now_to_the_beginning_and_back():
    life, session = lived(), watching()
    session = after(session, LookAround(False), life)
    assert session.looks_back == 98
    for _ in range(60):
        session = after(session, LookAround(False), life)
    assert session.looks_back == 0
    for _ in range(60):
        session = after(session, LookAround(True), life)
    assert session.looks_back is None


def test_where_the_past_is_not_known_nothing_is_shown_of_it():
    unknown = world()
    assert project(watching(looks_back=5), unknown).back is None
    assert project(watching(), unknown).n_lived == 0
    assert "nothing is known" in html_past.past_facts(project(watching(), unknown), None)
    assert after(watching(), LookAround(False), unknown).looks_back is None


def test_another_agent_is_shown_as_it_is_now():
    life = lived()
    session = after(watching(), LookBack(25), life)
    assert after(session, ChooseSource(Path("/agents/two.ao2")), life).looks_back is None


def test_only_what_stood_is_drawn_and_it_stands_where_it_always_stands():
    life, gallery = lived(), Gallery()
    pictures = {}
    for step in (15, 25, 45, 95):
        view = project(after(watching(), LookBack(step), life), life)
        assert view.back is not None
        assert view.spec is not None
        key = ("past file", str(FILE), 0)
        then = view.back.moment.view
        pictures[step] = gallery.get_past(key, view.back.past, then, view.spec, view.look)
        drawn = np.flatnonzero(pictures[step].sizes)
        assert drawn.tolist() == np.flatnonzero(then.is_alive).tolist()
        assert len(pictures[step].edges) == np.count_nonzero(then.parents[drawn] >= 0)
        np.testing.assert_allclose(
            pictures[step].positions[drawn],
            pictures[15].ground.positions[drawn] @ np.eye(2, 3),  # pyright: ignore
            atol=1e-6,
        )
    assert pictures[15].discs[1].astype(bool).sum() == 1
    assert pictures[95].discs[1].astype(bool).sum() == 2
    gallery.close()


def test_what_goes_away_later_is_drawn_last_so_that_its_going_changes_little():
    life, gallery = lived(), Gallery()
    view = project(after(watching(), LookBack(95), life), life)
    assert view.back is not None
    assert view.spec is not None
    past = view.back.past
    survivors = np.array([True, True, False, True, True])
    past = replace(past, now=replace(past.now, is_alive=survivors))
    then = view.back.moment.view
    picture = gallery.get_past(("past file", "", 0), past, then, view.spec, view.look)
    assert picture is not None
    assert picture.drawn.tolist() == [0, 1, 3, 4, 2]
    gallery.close()


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    made = make_server("127.0.0.1", 0)
    yield made
    made.stop()


def test_what_is_not_known_of_the_past_is_not_told_as_if_it_were(server):
    life, gallery = lived(), Gallery()
    panel = LegendPanel(server.gui, 1, Inbox())
    said = []
    for command in (LookBack(25), LookBack(None)):
        view = project(after(watching(), command, life), life)
        forest, key = view.forest, ("file", str(FILE), 0)
        assert view.spec is not None
        assert forest is not None
        picture = gallery.get(key, forest, view.spec, view.look)
        if view.back is not None:
            then, key = view.back.moment.view, ("past file", str(FILE), 0)
            picture = gallery.get_past(key, view.back.past, then, view.spec, view.look)
        panel.sync(view, picture)
        said.append(panel._text.content)
    gallery.close()
    assert "weights of then are not known" in said[0]
    assert "has tried nothing yet" not in said[0]
    assert "visited more often" not in said[0]
    assert "has tried nothing yet" in said[1]
    assert "visited more often" in said[1]
    kept = SimpleNamespace(moment=SimpleNamespace(snapshot=20))
    assert "is newer" in html_past.say_grey(kept)  # pyright: ignore


def test_what_goes_on_telling_of_now_says_so_while_the_past_is_shown(server):
    life, thinker = lived(), Thinker()
    why, inspect = WhyPanel(server.gui), InspectPanel(server.gui, 1, Inbox())
    what_if = WhatIfPanel(server.gui, 1, Inbox())
    said = {}
    for step in (25, None):
        view = project(after(watching(selected=4), LookBack(step), life), life)
        why.sync(view, "")
        inspect.sync(view, thinker, Jobs())
        what_if.sync(view, None, Jobs())
        said[step] = (why._line.content, inspect._line.content, what_if._line.content)
    thinker.close()
    for past, now in zip(said[25], said[None], strict=True):
        assert "ao-warn" in past
        assert now == ""
    assert "the decision of the replay, not what" in said[25][0]
    assert "as it is now, not as it was" in said[25][1]
    assert "canvas shows the past" in said[25][2]
