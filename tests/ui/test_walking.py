"""Walking through the stages of a step: in order, on the forest, and without touching the run."""

import itertools

import numpy as np
import pytest

from ao2viz.core.config import Preset
from ao2viz.core.growth import GrowthKind
from ao2viz.recording.cycle import Stage
from ao2viz.training.runner import InlineRunner
from ao2viz.training.states import Pause, RunStatus, Start, Step
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.commands import Move, Transport
from ao2viz.ui.dialog_commands import NextStage
from ao2viz.ui.downloads import Notify
from ao2viz.ui.gallery import Gallery
from ao2viz.ui.html_cycle import cycle_stages
from ao2viz.ui.overlay import Moment, overlay
from ao2viz.ui.reduce import follow, reduce
from ao2viz.ui.session import Session
from ao2viz.ui.staging import at_stage
from ao2viz.ui.view import project
from ao2viz.ui.world import World


class Page:
    """One browser's session on a run that works in this thread."""

    def __init__(self, preset: Preset) -> None:
        self.runner = InlineRunner()
        overrides = {Preset.ANTICIPATING: {"warmup_steps": 60}, Preset.PAPER: {"threshold": 0.98}}
        self.runner.submit(Start("CartPole-v1", preset, 1, 5000, overrides[preset]))
        while self.runner.latest().status is RunStatus.PREPARING:
            self.runner.advance(0.0)
        self.runner.submit(Pause())
        for _ in range(80):  # Step by step, so that it is the same place on any machine.
            self.runner.submit(Step())
            self.runner.advance()
        update = self.runner.latest()
        walked = Session(source=None, walked=update.cycle.n_steps, stage=Stage.CLEANSE)
        self.session, self.world = walked, World(update=update)

    def press(self, command=None) -> tuple:
        self.session, effects = reduce(self.session, command or NextStage(), self.world)
        for effect in effects:
            if isinstance(effect, Step):
                self.runner.submit(effect)
                self.runner.advance()
        before, now = self.world.update, self.runner.latest()
        self.session = follow(self.session, before, now)
        self.world = World(update=now)
        return effects

    @property
    def view(self):
        return project(self.session, self.world)


@pytest.fixture(scope="module", params=Preset)
def page(request) -> Page:
    return Page(request.param)


def test_a_press_is_a_stage_and_six_are_a_step(page):
    for _ in range(2):
        before = page.world.update.n_steps
        stages, steps = [], 0
        for _ in Stage:
            steps += len(page.press())
            stages.append(page.view.walk.stage)
        assert stages == list(Stage)
        assert steps == 1
        assert page.world.update.n_steps == before + 1
        assert page.view.walk.cycle.n_steps == before + 1


def test_the_canvas_shows_no_more_than_the_stage_has_come_to(page):
    gallery = Gallery(itertools.count(0.0, 100.0).__next__)  # It never rests between pictures.
    made = changed = 0
    for _ in range(6 * 40):
        page.press()
        view = page.view
        picture = gallery.get(view.forest_key, view.forest, view.spec, view.look)
        plain = overlay(Moment(view.decision, -1, view.seen), picture, view.forest, view.spec)
        shown = at_stage(plain, view.walk, picture)
        said = cycle_stages(view.walk, view.spec, view.forest)
        assert said.count("aria-current") == 1
        words = " ".join(label.text for label in shown.labels)
        cycle = view.walk.cycle
        match view.walk.stage:
            case Stage.SAMPLE:
                assert len(shown.path) == len(shown.voters) == 0
                assert "option" not in words
            case Stage.FIND:
                assert np.array_equal(shown.path, plain.path)
                assert "distance" in words
                assert "→" not in words
            case Stage.ACT:
                assert f"→ {view.spec.action_names[cycle.decision.action]}" in words
            case Stage.ACCOMMODATE:
                events = cycle.of(GrowthKind.CREATED)
                assert len(shown.voters) == len(events)
                assert all(f"new option {e.option}" in words for e in events[:1])
                made += len(events)
            case Stage.ASSIMILATE:
                assert len(shown.voters) == min(64, len(np.unique(cycle.options)))
                assert ("→" in words) == (len(cycle.options) > 0)
                changed += len(cycle.options)
            case Stage.CLEANSE:
                assert len(shown.voters) == len(cycle.of(GrowthKind.REMOVED))
    assert made > 0
    assert changed > 0
    gallery.close()


def test_looking_at_another_step_hides_the_stages_and_a_press_returns(page):
    page.press()
    while len(page.world.update.episode) < 3:
        page.press()
    stage = page.view.walk.stage
    page.press(Move(Transport.FIRST))
    assert page.view.walk is None
    page.press()
    assert page.view.walk is not None
    assert page.view.walk.stage.number == (stage.number + 1) % 6


def test_a_run_that_goes_on_cannot_be_walked_through():

    world = World(update=RunUpdate(RunStatus.RUNNING))
    _, (told,) = reduce(Session(), NextStage(), world)
    assert isinstance(told, Notify)
    assert "Only a paused run" in told.body
    assert not project(Session(), world).can_walk
