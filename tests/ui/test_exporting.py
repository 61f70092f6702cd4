"""Exporting from the page: what fits what, that it reads back, and that it can be ended."""

import io
import json
import time
import zipfile
from dataclasses import replace
from pathlib import Path

import networkx as nx
import pytest
from PIL import Image

from ao2viz.agent import AO2
from ao2viz.exports.formats import PURPOSES, Format, Scope, scopes_of
from ao2viz.training.branching import Takeover
from ao2viz.training.states import Pause
from ao2viz.ui import exporting
from ao2viz.ui.branches import Branch
from ao2viz.ui.downloads import Notify, SaveFile
from ao2viz.ui.jobs import Begin, Jobs
from ao2viz.ui.questions import ChooseFormat, ChooseScope, Export, ExportOption, Task
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session
from ao2viz.ui.view import project
from ao2viz.ui.world import ShelfItem, World
from tests.training.workers import prepared, start
from tests.ui.agents import saved_agent

FILE = Path("/agents/my =agent.ao2")


@pytest.fixture(scope="module")
def w() -> World:
    agent = AO2("CartPole-v1", seed=0, warmup_steps=50, levels=1).learn(200)
    agent.record_episode(1)
    agent.record_episode(2)
    return World(shelf=(ShelfItem(FILE, "one"),), opened={FILE: agent.to_saved()})


def watching(**more) -> Session:
    return Session(source=FILE, is_playing=False, **more)


def written(session: Session, w: World):
    """What the browser is handed; or the words that say why it is not."""
    _, (begin,) = reduce(session, Export(), w)
    if isinstance(begin, Notify):
        return begin.body
    assert isinstance(begin, Begin)
    jobs = Jobs()
    jobs.begin(begin)
    deadline = time.monotonic() + 120
    while not (state := jobs.look(begin.task, begin.about)).is_done:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return state.latest if isinstance(state.latest, SaveFile) else state.error


def test_every_format_has_one_purpose():
    assert sorted(kind.value for kinds in PURPOSES.values() for kind in kinds) == sorted(
        kind.value for kind in Format
    )


@pytest.mark.parametrize("format", Format)
def test_a_choice_that_does_not_fit_becomes_one_that_does(w, format):
    for scope in Scope:
        session = reduce(watching(), ChooseScope(scope), w)[0]
        session = reduce(session, ChooseFormat(format), w)[0]
        chosen = project(session, w).export
        assert chosen.scope in scopes_of(format)
        if scope in scopes_of(format):
            assert chosen.scope is scope


def test_an_episode_and_the_whole_agent_are_two_things(w):
    session = watching(export=Format.JSON, scope=Scope.EPISODE, episode=1)
    one = written(session, w)
    document = json.loads(one.content)
    assert one.name == "my--agent-episode-2.json"
    assert len(document["episodes"]) == 1
    assert document["episodes"][0]["seed"] == w.opened[FILE].episodes[1].seed
    everything = written(replace(session, scope=Scope.AGENT), w)
    assert everything.name == "my--agent.json"
    assert len(json.loads(everything.content)["episodes"]) == 2


def test_a_moment_is_that_of_the_replay(w):
    session = watching(export=Format.PATH_SVG, position=4.0)
    file = written(session, w)
    assert file.name == "my--agent-episode-1-step-4-path-svg.svg"
    decided = w.opened[FILE].episodes[0].decisions[4]
    assert str(decided.path[-1]) in file.content.decode()
    with Image.open(io.BytesIO(written(replace(session, export=Format.PNG), w).content)) as image:
        assert image.width > 100


def test_the_selected_option_is_saved_from_the_inspector(w):
    session, effects = reduce(watching(), ExportOption(), w)
    assert "Select an option first" in effects[0].body
    file = written(watching(selected=0, export=Format.OPTION), w)
    assert file.name == "my--agent-option-0.md"
    assert file.content.decode().startswith("# Option 0")
    session, (begin,) = reduce(watching(selected=0), ExportOption(), w)
    assert (session.export, begin.task) == (Format.OPTION, Task.EXPORT)
    told = json.loads(written(watching(selected=0, export=Format.OPTION_JSON), w).content)
    assert told["option"]["option"] == 0


def test_other_peoples_readers_read_it(w):
    graph = nx.read_graphml(io.BytesIO(written(watching(export=Format.GRAPHML), w).content))
    assert len(graph) == len(w.opened[FILE].forest_view())
    page = written(watching(export=Format.HTML), w).content.decode()
    assert page.lstrip().lower().startswith("<!doctype html>")


def test_a_folder_comes_as_a_zip(w):
    pytest.importorskip("tensorboardX")
    file = written(watching(export=Format.TENSORBOARD), w)
    assert file.name.endswith(".zip")
    with zipfile.ZipFile(io.BytesIO(file.content)) as archive:
        assert archive.testzip() is None
        assert any("tfevents" in name for name in archive.namelist())


@pytest.mark.parametrize(
    ("session", "opened", "words"),
    [
        (Session(source=None), {}, "no agent"),
        (watching(), {}, "no agent"),
        (watching(), {FILE: saved_agent()}, "no recorded episode"),
    ],
)
def test_what_cannot_be_exported_is_told_in_one_line(session, opened, words):
    told = written(session, World(opened=opened))
    assert words in told
    assert "\n" not in told


def test_past_the_last_step_there_is_no_moment(w):
    length = len(w.opened[FILE].episodes[0])
    told = written(watching(export=Format.PATH_PNG, position=float(length)), w)
    assert "step back" in told


def test_an_export_that_is_too_big_is_for_the_command_line(w, monkeypatch):
    monkeypatch.setattr(exporting, "MOST_BYTES", 10)
    told = written(watching(export=Format.CSV), w)
    assert "ao2viz export FILE --format csv" in told


def test_an_export_that_is_called_off_ends_and_leaves_nothing(w, monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    _, (begin,) = reduce(watching(export=Format.GIF), Export(), w)
    told = []

    def report(share: float) -> bool:
        told.append(share)
        return len(told) < 3

    with pytest.raises(exporting.CalledOffError, match="Called off"):
        begin.work(report)
    assert len(told) == 3
    assert list(tmp_path.iterdir()) == []


def test_a_held_run_is_exported_as_it_is_then():
    worker = prepared(start(total_steps=10_000))
    while worker.update().n_steps < 60:
        worker.advance(0.001)
    running = World(update=worker.update())
    told = written(Session(source=None, export=Format.JSON), running)
    assert told == "Hold the run to export its agent as it is then."
    worker.handle(Pause())
    held = World(update=worker.update())
    everything = written(Session(source=None, export=Format.JSON, scope=Scope.AGENT), held)
    document = json.loads(everything.content)
    assert everything.name == "Corridor-v0.json"
    assert document["agent"]["steps"] == held.update.n_steps
    one = written(Session(source=None, export=Format.JSON, scope=Scope.EPISODE), held)
    (episode,) = json.loads(one.content)["episodes"]
    assert [
        step["decision"]["action"] for step in episode["steps"]
    ] == held.update.episode.actions.tolist()


def test_a_branch_is_not_taken_for_what_the_agent_did(w):
    main = w.opened[FILE].episodes[0]
    session = watching(export=Format.JSON, branch=Branch(main, (Takeover(2, 0),), main))
    for scope in (Scope.EPISODE, Scope.MOMENT):
        chosen = replace(session, scope=scope, export=format_of(scope))
        assert "main line" in written(chosen, w)
    assert len(json.loads(written(replace(session, scope=Scope.AGENT), w).content)["episodes"]) == 2


def format_of(scope: Scope) -> Format:
    return Format.PATH_SVG if scope is Scope.MOMENT else Format.JSON
