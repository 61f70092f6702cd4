"""`ao2viz paper`, as the process that people run."""

import json
from pathlib import Path

import pytest

from ao2viz.baselines.algorithm import Acting, Algorithm
from ao2viz.experiments.table import read
from ao2viz.exports.learner_curves import read_learner_curves
from tests.cli.processes import Cli


def test_a_piece_is_run_and_reported_and_not_run_again(cli: Cli, tmp_path: Path) -> None:
    piece = (
        "paper",
        "--quick",
        "--only",
        "ppo",
        "--only",
        "CartPole-v0",
        "--workers",
        "1",
        "--json",
    )
    done = cli(*piece, "--out", "there")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert (summary["runs"], summary["done"], summary["done_before"]) == (1, 1, 0)
    rows = read(tmp_path / "there" / "results.parquet")
    assert {one.run.preset for one in rows} == {Algorithm.PPO}
    assert {one.decide_by for one in rows} == set(Acting)
    assert any(one.episode_returns for one in rows)
    report = (tmp_path / "there" / "report.md").read_text("utf-8")
    assert "1 of 40 runs are done" in report
    assert "<svg" in (tmp_path / "there" / "report.html").read_text("utf-8")
    assert (tmp_path / "there" / "curves-CartPole-v0.svg").exists()
    (curve,) = read_learner_curves(tmp_path / "there" / "curves.json")
    assert (curve.env, curve.learner, curve.seeds) == ("CartPole-v0", "PPO", (900,))
    greedy = [one for one in rows if one.decide_by is Acting.GREEDY]
    assert curve.returns[0] == pytest.approx([one.mean_return for one in greedy], abs=1e-3)
    again = cli(*piece, "--out", "there")
    assert json.loads(again.stdout)["done_before"] == 1
    assert read(tmp_path / "there" / "results.parquet") == rows


def test_a_report_needs_no_runs(cli: Cli, tmp_path: Path) -> None:
    done = cli("paper", "--report-only", "--out", "there")
    assert done.returncode == 0, done.stderr
    assert "The report is in there/report.html" in done.stdout
    assert "0 of " in (tmp_path / "there" / "report.md").read_text("utf-8")
    assert not (tmp_path / "there" / "results.parquet").exists()


def test_an_unknown_name_is_told_before_anything_is_run(cli: Cli, tmp_path: Path) -> None:
    done = cli("paper", "--only", "dqn", "--out", "there")
    assert done.returncode == 2
    assert "Expected one of paper, anticipating" in done.stderr
    assert not (tmp_path / "there").exists()
