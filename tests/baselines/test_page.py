"""docs/baselines.md names every algorithm and every setting, with its default."""

import re
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


@pytest.mark.parametrize("field", fields(Settings), ids=lambda field: field.name)
def test_every_setting_is_explained_with_what_it_is(field):
    cells = ROWS[field.name][1:5]
    assert re.match(rf"{re.escape(as_text(field.default))}(?![\d.])", cells[0])
    for algorithm in (one for one in Algorithm if not one.is_reference):
        for env in ("CartPole-v0", "Acrobot-v1", "Pendulum-v1"):
            found = as_text(getattr(make_settings(algorithm, env, {}), field.name))
            assert any(re.search(rf"(?<![\d.]){re.escape(found)}(?![\d.])", one) for one in cells)
