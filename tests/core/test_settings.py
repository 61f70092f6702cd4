"""What can be set, as people are told of it, and what changing it in the middle of a life does."""

import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from ao2viz import AO2, Preset
from ao2viz.core.config import make_config
from ao2viz.core.settings import TakesEffect, settings_of
from ao2viz.training.loop import Stepper

DOCS = Path(__file__).resolve().parents[2] / "docs" / "algorithm.md"


def plain(text: str) -> str:
    return re.sub(r"`|\(\[[^)]*\)\)|\\", "", text)


@pytest.mark.parametrize("preset", Preset)
def test_every_setting_is_told_of_in_the_words_of_its_documentation(preset):
    page = plain(DOCS.read_text("utf-8"))
    told = settings_of(preset)
    assert {s.name for s in told} == {f.name for f in fields(make_config(preset, {}))}
    for setting in told:
        row = re.search(rf"^\| {setting.name} \|.*$", page, re.MULTILINE)
        assert row is not None
        assert setting.meaning in row[0], f"docs/algorithm.md says of it: {row[0]}"


@pytest.mark.parametrize("preset", Preset)
def test_what_is_told_is_what_is_checked(preset):
    for setting in settings_of(preset):
        make_config(preset, {setting.name: setting.default})
        for choice in setting.choices:
            make_config(preset, {setting.name: choice})
        if setting.range is None:
            continue
        low, high = setting.range
        make_config(preset, {setting.name: low})
        make_config(preset, {setting.name: high})
        for beyond in (low - 1, high + 1):
            with pytest.raises(ValueError, match=f"Expected {setting.name} between"):
                make_config(preset, {setting.name: beyond})


def life(preset: Preset, changes: dict, settings: dict, steps: int = 400) -> tuple[AO2, Stepper]:
    """An agent whose settings change after half of its steps."""
    agent = AO2("CartPole-v1", preset, seed=1, **settings)
    stepper = agent.stepper()
    for step in range(steps):
        if step == steps // 2 and changes:
            agent.change_settings(**changes)
        stepper.step()
    return agent, stepper


@pytest.mark.parametrize("preset", Preset)
def test_changing_a_setting_to_what_it_is_changes_nothing(preset):
    usual = {"warmup_steps": 60} if preset is Preset.ANTICIPATING else {}
    config = make_config(preset, usual)
    same = {
        s.name: getattr(config, s.name)
        for s in settings_of(preset)
        if s.takes_effect is not TakesEffect.NEW_RUN and s.name != "threshold"
    }
    one, _ = life(preset, {}, usual)
    # The catalogue's own settings are left alone.
    other, _ = life(preset, {k: getattr(one.config, k) for k in same}, usual)
    for a, b in zip(vars(one.forest).values(), vars(other.forest).values(), strict=True):
        assert np.array_equal(a, b)


@pytest.mark.parametrize("preset", Preset)
def test_exploring_more_from_now_on_is_seen_from_the_next_step(preset):
    name = "epsilon" if preset is Preset.PAPER else "epsilon_end"
    settings = {} if preset is Preset.PAPER else {"warmup_steps": 60, "epsilon_steps": 100}
    _, calm = life(preset, {name: 0.0}, settings)
    _, wild = life(preset, {name: 1.0}, settings)
    assert not any(d.explored for d in calm.episode().decisions[-5:])
    assert all(d.explored for d in wild.episode().decisions[-5:])


@pytest.mark.parametrize("preset", Preset)
def test_what_a_forest_is_made_of_cannot_change_under_way(preset):
    agent = AO2("CartPole-v1", preset)
    for setting in settings_of(preset):
        if setting.takes_effect is TakesEffect.NEW_RUN:
            with pytest.raises(ValueError, match=f"{setting.name} takes effect in a new run only"):
                agent.change_settings(**{setting.name: setting.default})
