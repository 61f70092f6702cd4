"""Whatever is pressed, in whatever order, breaks no browser's screen; no page is opened."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ao2viz.agent import AO2
from ao2viz.core.config import Preset
from ao2viz.core.decision import NO_OPTION
from ao2viz.training.states import Pause, RunStatus, Step, Stop
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.browser import Browser
from ao2viz.ui.commands import (
    ChooseAxis,
    ChooseSmoothing,
    Command,
    Edit,
    Field,
    Pick,
    SetTrainingSpeed,
)
from ao2viz.ui.frames import FrameStore
from ao2viz.ui.gallery import Gallery
from ao2viz.ui.inbox import Inbox
from ao2viz.ui.jobs import Begin
from ao2viz.ui.questions import CallOff, Task
from ao2viz.ui.reduce import advance, follow, reduce
from ao2viz.ui.replay_commands import SetPlaySpeed
from ao2viz.ui.security import make_server
from ao2viz.ui.session import Session
from ao2viz.ui.stage import Stage
from ao2viz.ui.thinker import Thinker
from ao2viz.ui.view import project
from ao2viz.ui.world import LoadFailure, ShelfItem, World
from tests.training.workers import prepared, start

CARTPOLE, PENDULUM, BROKEN, COMING = (
    Path(f"/agents/{name}.ao2") for name in ("cartpole", "pendulum", "broken", "coming")
)
CAMERA = SimpleNamespace(
    image_width=1000, image_height=700, fov=0.6, position=np.array([0.0, 0.0, 9.0]),
    wxyz=np.array([0.0, 1.0, 0.0, 0.0]), up_direction=np.array([0.0, 1.0, 0.0]),
    look_at=np.zeros(3), near=0.1, far=100.0,
)  # fmt: skip


@lru_cache(maxsize=1)
def worlds() -> tuple[World, ...]:
    """The same agents beside a run in each of its states, and one in which there is nothing."""
    opened = {BROKEN: LoadFailure("It is broken.")}
    for path, env_id, preset in (
        (CARTPOLE, "CartPole-v1", Preset.ANTICIPATING),
        (PENDULUM, "Pendulum-v1", Preset.PAPER),
    ):
        more = {"warmup_steps": 50, "levels": 1} if preset is Preset.ANTICIPATING else {}
        agent = AO2(env_id, preset, seed=0, **more).learn(150)
        agent.record_episode(1)
        agent.record_episode(2)
        opened[path] = agent.to_saved()
    shelf = tuple(
        ShelfItem(path, path.stem, "CartPole-v1") for path in (CARTPOLE, PENDULUM, BROKEN, COMING)
    )
    common = World(shelf=shelf, opened=opened, env_ids=("CartPole-v1",))
    worker = prepared(start())
    updates = [RunUpdate(), RunUpdate(RunStatus.PREPARING, run_id=1)]
    while worker.update().n_steps < 70:
        worker.advance(0.001)
    updates.append(worker.update())
    worker.handle(Pause())
    updates.append(worker.update())
    worker.handle(Step())
    worker.advance(0.01)
    updates.append(worker.update())
    worker.handle(Stop())
    updates.append(worker.update())
    return (World(), *(replace(common, update=update) for update in updates))


PATHS = st.sampled_from([CARTPOLE, PENDULUM, BROKEN, COMING, Path("/etc/passwd")])
NUMBERS = st.one_of(st.integers(-3, 200), st.sampled_from([-(2**40), 2**40]))
FLOATS = st.one_of(st.floats(), st.floats(-3, 3))
WORDS = st.one_of(
    st.text(max_size=12),
    st.sampled_from(["margin < 0.1", "1, 2, 3, 4", "nan", "0.5", "../x", "<b>", "step = 3"]),
)


def _commands() -> st.SearchStrategy[Command]:
    for kind, strategy in ((Path, PATHS), (int, NUMBERS), (float, FLOATS), (str, WORDS)):
        st.register_type_strategy(kind, strategy)
    flat = [each for kind in get_args(Command) for each in (get_args(kind) or (kind,))]
    # What a page offers in a list of its own; and clicks, which the canvas answers.
    listed = (Pick, Edit, SetPlaySpeed, SetTrainingSpeed, ChooseAxis, ChooseSmoothing)
    flat = [kind for kind in flat if kind not in listed]
    edits = st.one_of(
        st.builds(Edit, st.sampled_from([Field.CUSTOM_ENV, Field.ENV, Field.FILE_NAME]), WORDS),
        st.builds(Edit, st.sampled_from([Field.SEED, Field.STEPS]), NUMBERS),
        st.builds(ChooseAxis, st.integers(0, 2), st.one_of(st.none(), st.integers(0, 3))),
        st.builds(ChooseSmoothing, st.sampled_from([1, 5, 100])),
        st.builds(SetPlaySpeed, st.sampled_from([0.125, 1.0, 8.0])),
        st.builds(SetTrainingSpeed, st.sampled_from([None, 3.0])),
        st.builds(Edit, st.just(Field.PRESET), st.sampled_from([p.value for p in Preset])),
    )
    return st.one_of(edits, *(st.from_type(kind) for kind in flat))


@pytest.fixture(scope="module")
def screen() -> Iterator[tuple]:
    server, inbox = make_server("127.0.0.1", 0), Inbox()
    client = SimpleNamespace(
        client_id=7, gui=server.gui, scene=server.scene, atomic=server.atomic, camera=CAMERA
    )
    browser = Browser(client, Stage(server), inbox)  # pyright: ignore[reportArgumentType]
    shared = Gallery(), FrameStore(), Thinker()
    yield browser, shared
    browser.jobs.close()
    for each in shared:
        each.close()
    server.stop()


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    st.lists(
        st.tuples(_commands(), st.integers(0, 6), st.sampled_from([0.0, 0.05, 3.0])),
        min_size=1,
        max_size=12,
    )
)
def test_no_command_breaks_a_screen(screen, tape):
    browser, shared = screen
    session, before = Session(source=CARTPOLE), worlds()[1]
    for command, index, seconds in tape:
        world = worlds()[index]
        session = follow(session, before.update, world.update)
        before = world
        session, effects = reduce(session, command, world)
        for effect in effects:
            if isinstance(effect, Begin) and effect.task in (Task.WHOLE, Task.MUTE):
                browser.jobs.begin(effect)  # Its panel shows whatever it has come to.
            elif isinstance(effect, CallOff):
                browser.jobs.call_off(effect.task)
        session = advance(session, world, seconds)
        view = project(session, world)
        assert 0 <= view.transport.position <= max(0, view.transport.last)
        if view.forest is not None and view.selected != NO_OPTION:
            assert 0 <= view.selected < len(view.forest.is_alive)
        assert np.isfinite(view.transport.position)
        browser.sync(view, *shared)
