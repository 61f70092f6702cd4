"""docs/baselines.md names every algorithm and every setting, with its default."""

from dataclasses import fields
from pathlib import Path

import pytest

from ao2viz.baselines.algorithm import Algorithm
from ao2viz.baselines.settings import Settings, make_settings

PAGE = (Path(__file__).parents[2] / "docs" / "baselines.md").read_text("utf-8")
ROWS = {
    row[0]: row
    for row in (
        [cell.strip(" `") for cell in line.strip("|").split("|")]
        for line in PAGE.splitlines()
        if line.startswith("| `")
    )
}


@pytest.mark.parametrize("algorithm", Algorithm)
def test_every_algorithm_is_explained(algorithm):
    assert algorithm.value in ROWS


def as_text(value):
    return str(value).lower() if isinstance(value, bool) else f"{value:g}"


def told(cell):
    """What a cell says for each algorithm it names, and under "" for the others."""
    parts = [part.split("` ") for part in cell.replace("; `", ";").split(";") if part]
    return {part[0] if len(part) == 2 else "": part[-1] for part in parts}


@pytest.mark.parametrize("field", fields(Settings), ids=lambda field: field.name)
def test_every_setting_is_explained_with_what_it_is(field):
    always, *of_envs = map(told, ROWS[field.name][1:5])
    assert always[""] == as_text(field.default)
    for algorithm in (one for one in Algorithm if not one.is_reference):
        name = algorithm.value
        for env, here in zip(("CartPole-v0", "Acrobot-v1", "Pendulum-v1"), of_envs, strict=True):
            # What is told of the algorithm goes before what is told of the environment.
            said = here.get(name) or always.get(name) or here.get("") or always[""]
            assert said == as_text(getattr(make_settings(algorithm, env, {}), field.name))
