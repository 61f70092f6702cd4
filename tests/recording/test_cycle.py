"""A single step told apart into its stages: exactly what changed, and nothing changes by asking."""

import re

import numpy as np
import pytest

from ao2viz import AO2, Preset
from ao2viz.core.growth import GrowthKind
from ao2viz.explain.cycle import explain_stage
from ao2viz.explain.words import number
from ao2viz.recording.cycle import Stage
from ao2viz.training.loop import cycle_of
from ao2viz.training.runner import InlineRunner
from ao2viz.training.states import Pause, Start, Step

SETTINGS = {Preset.PAPER: {"epsilon": 0.1}, Preset.ANTICIPATING: {"warmup_steps": 60}}


def walk(preset: Preset, steps: int, *, looks: bool):
    """An agent after so many steps, and the cycle of each if it was looked at."""
    agent = AO2("CartPole-v1", preset, seed=2, **SETTINGS[preset])
    stepper, cycles = agent.stepper(), []
    for _ in range(steps):
        before = agent.forest if looks else None
        result = stepper.step()
        if before is not None:
            cycles.append((before, cycle_of(before, agent.forest, result), agent.forest))
    return agent, cycles


@pytest.mark.parametrize("preset", Preset)
def test_the_cycle_is_what_changed_and_looking_changes_nothing(preset):
    agent, cycles = walk(preset, 200, looks=True)
    other, _ = walk(preset, 200, looks=False)
    for a, b in zip(vars(agent.forest).values(), vars(other.forest).values(), strict=True):
        assert np.array_equal(a, b)
    n_changed = n_made = 0
    for before, cycle, after in cycles:
        weights = before.weights.copy()
        assert (weights[cycle.options, cycle.actions] == cycle.before).all()
        weights[cycle.options, cycle.actions] = cycle.after
        n = len(before.parents)
        alive = before.is_alive & after.is_alive[:n]
        assert np.array_equal(weights[alive], after.weights[:n][alive])
        assert (np.diff(np.abs(cycle.after - cycle.before)) <= 0).all()
        made = {event.option for event in cycle.of(GrowthKind.CREATED)}
        assert made == set(range(n, len(after.parents)))
        gone = {event.option for event in cycle.of(GrowthKind.REMOVED)}
        assert gone == set(np.flatnonzero(before.is_alive & ~after.is_alive[:n]).tolist())
        n_changed, n_made = n_changed + len(cycle.options), n_made + len(made)
    assert n_changed > 10
    assert n_made > 10


@pytest.mark.parametrize("preset", Preset)
def test_every_stage_is_said_with_its_numbers(preset):
    agent, cycles = walk(preset, 200, looks=True)
    for _, cycle, after in cycles:
        said = {stage: explain_stage(cycle, stage, agent.spec, after) for stage in Stage}
        assert all(text.endswith(".") and "nan" not in text for text in said.values())
        assert f"Step {cycle.n_steps:,} begins" in said[Stage.SAMPLE]
        if len(cycle.decision.voters):
            assert f" is {cycle.decision.path[-1]}, at distance" in said[Stage.FIND]
            assert number(cycle.decision.distance) in said[Stage.FIND]
        else:
            assert "no options yet" in said[Stage.FIND]
        assert f"It earned {number(cycle.reward)}" in said[Stage.ACT]
        made = cycle.of(GrowthKind.CREATED)
        assert ("No option was made" in said[Stage.ACCOMMODATE]) == (not made)
        assert all(f"Option {e.option} was made" in said[Stage.ACCOMMODATE] for e in made[:4])
        told = re.match(r"([\d,]+) weight", said[Stage.ASSIMILATE])
        assert (int(told[1].replace(",", "")) if told else 0) == len(cycle.options)
        assert ("let go or merged" in said[Stage.CLEANSE]) == bool(cycle.of(GrowthKind.REMOVED))


def test_a_forest_that_regrows_within_a_step_tells_what_merged():
    agent = AO2("CartPole-v1", seed=0, warmup_steps=60, attention_growth=0.01)
    stepper = agent.stepper()
    for _ in range(1500):
        before = agent.forest
        result = stepper.step()
        cycle = cycle_of(before, agent.forest, result)
        if cycle.of(GrowthKind.REMOVED):
            said = explain_stage(cycle, Stage.CLEANSE, agent.spec, agent.forest)
            first = cycle.of(GrowthKind.REMOVED)[0]
            assert f"{len(cycle.of(GrowthKind.REMOVED)):,} option" in said
            assert str(first.option) in said
            assert "Attention changed" in explain_stage(
                cycle, Stage.ASSIMILATE, agent.spec, agent.forest
            )
            return
    pytest.fail("Nothing merged in 1,500 steps.")


def test_a_held_run_shows_the_cycle_of_its_latest_single_step():
    runner = InlineRunner()
    runner.submit(Start("CartPole-v1", total_steps=400, overrides={"warmup_steps": 60}))
    while runner.latest().n_steps < 100:
        runner.advance(0.01)
    runner.submit(Pause())
    assert runner.latest().cycle is None
    runner.submit(Step())
    runner.advance()
    update = runner.latest()
    assert update.cycle.n_steps == update.n_steps
    assert update.cycle.decision is update.episode.decisions[-1]
