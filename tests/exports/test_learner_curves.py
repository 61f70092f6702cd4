"""Learning curves as a file: what is written is read again, and nothing else is believed."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

from ao2viz import resources
from ao2viz.experiments.table import read
from ao2viz.exports.learner_curves import read_learner_curves, to_json, write_learner_curves_csv
from ao2viz.paper.learners import learner_curves
from ao2viz.paper.plan import FULL, make_tasks
from ao2viz.paper.published import ENVS
from tests.figures.curves import behind

CURVES = [behind("PPO", 0), behind("DAC+PPO", 1), behind("PPO", 0, env="Pendulum-v1")]
DOCS = Path(__file__).resolve().parents[2] / "docs" / "paper"


def test_what_is_written_is_read_again(tmp_path):
    (tmp_path / "curves.json").write_text(to_json(CURVES))
    found = read_learner_curves(tmp_path / "curves.json")
    assert [(one.env, one.learner, one.rank, one.seeds) for one in found] == [
        (one.env, one.learner, one.rank, one.seeds) for one in CURVES
    ]
    for one, other in zip(found, CURVES, strict=True):
        np.testing.assert_array_equal(one.steps, other.steps)
        np.testing.assert_array_equal(one.returns, other.returns)


def test_the_curves_that_ship_are_those_of_the_runs_in_the_documentation():
    written = to_json(learner_curves(read(DOCS / "results.parquet"), make_tasks(FULL, 5, 3)))
    assert resources.learner_curves().read_text("utf-8") == written
    found = read_learner_curves(resources.learner_curves())
    assert {one.env for one in found} == set(ENVS)
    assert all(np.isfinite(one.returns).all() for one in found)


def test_every_seed_and_checkpoint_is_a_row_of_the_table():
    stream = io.BytesIO()
    write_learner_curves_csv(CURVES[:2], stream)
    rows = list(csv.DictReader(io.StringIO(stream.getvalue().decode("utf-8-sig"))))
    assert len(rows) == 2 * 2 * 3
    assert rows[4] == {
        "environment": "CartPole-v1", "learner": "PPO", "seed": "901", "steps": "1000",
        "mean return": "70.0",
    }  # fmt: skip


def changed(**changes: object) -> str:
    found = json.loads(to_json(CURVES))
    found["curves"][1].update(changes)
    return json.dumps(found)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("{", "in JSON"),
        ("[]", "to be an object"),
        ("{}", "Expected 'format' in the file, but there is none"),
        ('{"format": "x"}', "to be ao2viz-learner-curves"),
        ('{"format": "ao2viz-learner-curves", "format_version": 2}', "'format_version'"),
        (changed(learner="<b>"), "short plain name"),
        (changed(env="a" * 99), "short plain name"),
        (changed(learner="SAC"), "among the learners"),
        (changed(steps=[100, 100, 200]), "rising whole numbers from 1 on as 'steps'"),
        (changed(steps=[0, 100, 200]), "rising whole numbers"),
        (changed(steps=[]), "rising whole numbers"),
        (changed(seeds=[1.5, 2]), "as 'seeds'"),
        (changed(seeds=[900]), "Expected 1 lists of 3 finite returns"),
        (changed(returns=[[1, 2], [1, 2, 3]]), "Expected 2 lists of 3"),
        (changed(returns=[[1, 2, True], [1, 2, 3]]), "Expected 2 lists of 3"),
        (changed(returns=[[1, 2, 1e400], [1, 2, 3]]), "Infinity is not JSON"),
        (changed(returns=[7, 8]), "Expected 2 lists of 3"),
        (" " * (4 * 2**20 + 1), "at most 4 MiB"),
    ],
)
def test_what_is_no_such_file_is_told_in_one_line(tmp_path, content, problem):
    (tmp_path / "mine.json").write_text(content)
    with pytest.raises(ValueError, match=r"mine.json is no curves.json") as raised:
        read_learner_curves(tmp_path / "mine.json")
    assert problem in str(raised.value)
    assert "\n" not in str(raised.value)
