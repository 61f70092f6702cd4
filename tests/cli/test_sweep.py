"""`ao2viz sweep` and `ao2viz results`, as the processes that people run."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ao2viz import AO2, DecideBy
from ao2viz.cli import main
from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.table import read
from tests.cli.processes import TIMEOUT_S, Cli, environment, start
from tests.cli.test_bad_input import assert_one_clear_line

SMALL = ("--steps", "300", "--episodes", "2", "--workers", "2", "--out", "r.parquet")

# Leaves a file for every environment that is stepped, and can be slow, or fail, on purpose.
NOTING = """
import os, pathlib, time
import gymnasium
from gymnasium.envs.classic_control import CartPoleEnv

NOTES = pathlib.Path(os.environ["NOTES"])

class Noting(CartPoleEnv):
    steps = 0


    def step(self, action):
        self.steps += 1
        if self.steps == 100:
            (NOTES / f"{os.getpid()}-{time.monotonic_ns()}").touch()
            time.sleep(0.7 * (NOTES / "be slow").exists())
            if (NOTES / "fail").exists():
                raise RuntimeError("the motor\\nburned")
        return super().step(action)

gymnasium.register("Noting-v0", Noting, max_episode_steps=200)
"""


@pytest.fixture
def notes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where runs of the environments in `noting` leave a file each, named after their process."""
    (tmp_path / "noting.py").write_text(NOTING)
    folder = tmp_path / "notes"
    folder.mkdir()
    monkeypatch.setenv("NOTES", str(folder))
    return folder


def count(notes: Path) -> int:
    """Environments that were stepped; each run has one to learn in, and one to be evaluated in."""
    return len(list(notes.glob("*-*")))


def figures(rows: list[Evaluation]) -> dict[tuple, tuple]:
    """What must not depend on where and when a run was done."""
    found = {
        (one.run, one.steps, one.decide_by): (one.returns, one.options, one.stack_mean)
        for one in rows
    }
    assert len(found) == len(rows)
    return found


def test_a_sweep_fills_a_table_and_results_reads_it(cli: Cli, tmp_path: Path) -> None:
    sweep = (
        "sweep", "CartPole-v1", "Pendulum-v1", "--seeds", "0:2", "--set", "levels=2,3",
        "--checkpoints", "100,200", *SMALL,
    )  # fmt: skip
    done = cli(*sweep)
    assert done.returncode == 0, done.stderr
    assert "8 of 8 runs are in r.parquet." in done.stdout
    assert "8/8  " in done.stderr
    assert "to go)" in done.stderr
    rows = read(tmp_path / "r.parquet")
    assert len(rows) == 2 * 2 * 2 * 3 * 2
    for one in rows:
        if one.run.seed == 1 and one.steps == 300 and one.run.overrides == {"levels": 2}:
            agent = AO2(one.run.env, seed=1, levels=2).learn(300)
            agent.set_decide_by(one.decide_by)
            assert one.returns == tuple(agent.evaluate(2))
    results = cli("results", "r.parquet")
    assert results.returncode == 0, results.stderr
    assert results.stdout.count("levels=3") == 2 * 3 * 2
    groups = json.loads(cli("results", "r.parquet", "--json").stdout)["groups"]
    last = next(one for one in groups if one["environment"] == "Pendulum-v1" and one["steps"] > 200)
    assert last["seeds"] == [0, 1]
    assert last["settings"] == {"levels": 2}
    assert last["mean"] == pytest.approx(sum(last["means"]) / 2)
    assert last["interval"] == sorted(last["means"])

    again = cli(*sweep, "--json")
    assert again.returncode == 0
    summary = json.loads(again.stdout)
    assert (summary["runs"], summary["done"], summary["done_before"]) == (8, 8, 8)
    assert read(tmp_path / "r.parquet") == rows


def test_results_writes_a_page_and_draws_curves(cli: Cli, tmp_path: Path) -> None:
    sweep = ("sweep", "CartPole-v1", "--seeds", "3,5", "--checkpoints", "100", *SMALL)
    assert cli(*sweep).returncode == 0
    (tmp_path / "page.md").write_text("mine\n<!-- results: begin -->\n<!-- results: end -->\n")
    done = cli("results", "r.parquet", "--markdown", "page.md", "--plot", "curves.html", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["file"] == "r.parquet"
    page = (tmp_path / "page.md").read_text()
    assert page.startswith("mine\n")
    assert "### CartPole-v1, `anticipating`, 300 steps" in page
    drawn = (tmp_path / "curves.html").read_text()
    assert "steps of the environment" in drawn
    assert "anticipating, by one path" in drawn
    assert "<script src=" not in drawn, "It must show without a network."


@pytest.mark.parametrize("cluster", ["dask", "ray"])
def test_a_cluster_of_two_workers_gives_the_same_table(
    cli: Cli, notes: Path, tmp_path: Path, cluster: str
) -> None:
    pytest.importorskip({"dask": "distributed", "ray": "ray"}[cluster])
    sweep = ("sweep", "noting:Noting-v0", "--seeds", "0:4", *SMALL[:-1])
    started = cli(*sweep, f"{cluster}.parquet", "--cluster", cluster)
    assert started.returncode == 0, started.stderr
    assert "Traceback" not in started.stderr
    assert len({path.name.split("-")[0] for path in notes.glob("*-*")}) == 2, "Two processes."
    assert cli(*sweep, "local.parquet", "--workers", "1").returncode == 0
    there, here = (read(tmp_path / f"{name}.parquet") for name in (cluster, "local"))
    assert len(here) == 8
    assert figures(there) == figures(here)


def test_a_killed_sweep_goes_on_with_what_is_missing(cli: Cli, notes: Path, tmp_path: Path) -> None:
    sweep = ("sweep", "noting:Noting-v0", "--seeds", "0:6", *SMALL)
    (notes / "be slow").touch()
    process = start(tmp_path, *sweep)
    while not (tmp_path / "r.parquet").exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    process.kill()
    process.communicate(timeout=TIMEOUT_S)
    kept = read(tmp_path / "r.parquet")
    finished = {one.run.seed for one in kept}
    assert 0 < len(finished) < 6
    time.sleep(2.5)  # Its workers notice, and do not finish what nobody waits for.
    before = count(notes)
    time.sleep(1)
    assert count(notes) == before
    (notes / "be slow").unlink()
    done = cli(*sweep, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["done_before"] == len(finished)
    assert f"{len(finished)} of 6 runs are in r.parquet already." in done.stderr
    assert count(notes) == before + 2 * (6 - len(finished)), "No finished run was done again."
    rows = read(tmp_path / "r.parquet")
    assert rows[: len(kept)] == kept
    assert cli(*sweep[:-1], "whole.parquet").returncode == 0
    assert figures(rows) == figures(read(tmp_path / "whole.parquet"))


def test_an_interrupt_of_its_workers_alone_ends_nothing(notes: Path, tmp_path: Path) -> None:
    """In a terminal Ctrl-C reaches them too, at work or not; only the command decides on it."""
    (notes / "be slow").touch()
    process = start(tmp_path, "sweep", "noting:Noting-v0", "--seeds", "0:4", *SMALL)
    while len(workers := {int(note.name.split("-")[0]) for note in notes.glob("*-*")}) < 2:
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    for worker in workers:
        os.kill(worker, signal.SIGINT)
    output, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, errors
    assert "4 of 4 runs are in r.parquet." in output
    assert "Traceback" not in errors


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_keeps_what_is_finished_and_says_how_to_go_on(
    notes: Path, tmp_path: Path, number: signal.Signals, code: int
) -> None:
    (notes / "be slow").touch()
    # As in a terminal, where Ctrl-C reaches the workers as well.
    process = subprocess.Popen(
        [sys.executable, "-m", "ao2viz", "sweep", "noting:Noting-v0", "--seeds", "0:20", *SMALL],
        cwd=tmp_path,
        env=environment(tmp_path),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while not (tmp_path / "r.parquet").exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    os.killpg(process.pid, number)
    output, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == code, errors
    assert "Traceback" not in errors
    finished = len(read(tmp_path / "r.parquet")) // 2
    assert 0 < finished < 20
    assert f"Stopped. {20 - finished} runs left to do; the same command goes on" in errors
    assert f"{finished} of 20 runs are in r.parquet." in output
    assert not list(tmp_path.glob(".r.parquet*"))


def test_a_failing_run_is_told_and_the_others_go_on(cli: Cli, notes: Path, tmp_path: Path) -> None:
    (notes / "fail").touch()
    sweep = ("sweep", "noting:Noting-v0", "CartPole-v1", "--seeds", "0:2", *SMALL)
    done = cli(*sweep, "--json")
    assert done.returncode == 1
    assert "noting:Noting-v0 anticipating seed 1: failed: RuntimeError: the motor burned" in (
        done.stderr
    )
    assert "2 runs failed. 2 runs left to do; the same command goes on" in done.stderr
    assert "Traceback" not in done.stderr
    summary = json.loads(done.stdout)
    assert summary["done"] == 2
    assert {one["error"] for one in summary["failed"]} == {"RuntimeError: the motor burned"}
    assert {one.run.env for one in read(tmp_path / "r.parquet")} == {"CartPole-v1"}
    (notes / "fail").unlink()  # Mended, the same command does only what has failed.
    mended = cli(*sweep, "--json")
    assert mended.returncode == 0, mended.stderr
    assert json.loads(mended.stdout)["done_before"] == 2


def test_several_sweeps_share_a_table(cli: Cli, tmp_path: Path) -> None:
    assert cli("sweep", "CartPole-v1", "--seeds", "0", *SMALL).returncode == 0
    assert cli("sweep", "CartPole-v1", "--seeds", "0:2", *SMALL, "--steps", "400").returncode == 0
    rows = read(tmp_path / "r.parquet")
    assert sorted({(one.run.seed, one.steps) for one in rows}) == [(0, 300), (0, 400), (1, 400)]
    assert {one.decide_by for one in rows} == set(DecideBy)
    other = cli("sweep", "CartPole-v1", "--seeds", "0:9", *SMALL, "--episodes", "3")
    assert_one_clear_line(other, "with 2 episodes, not 3")


WRONG = {
    "no environment": (["sweep"], "ENV"),
    "unknown environment": (["sweep", "CartPole-v1", "CartPol-v1"], "CartPole-v1"),
    "unknown setting": (["sweep", "CartPole-v1", "--set", "lvels=3"], "Did you mean 'levels'"),
    "setting out of range": (["sweep", "CartPole-v1", "--set", "levels=3,99"], "but got 99"),
    "setting without value": (["sweep", "CartPole-v1", "--set", "levels=3,"], "NAME=VALUE,VALUE"),
    "setting twice": (["sweep", "CartPole-v1", "--set", "gamma=1", "--set", "gamma=0.9"], "twice"),
    "setting that is an option": (["sweep", "CartPole-v1", "--set", "seed=1"], "--seeds"),
    "malformed seeds": (["sweep", "CartPole-v1", "--seeds", "0-9"], "--seeds such as 0:10"),
    "no seeds": (["sweep", "CartPole-v1", "--seeds", "5:5"], "'5:5'"),
    "negative seeds": (["sweep", "CartPole-v1", "--seeds", "-1"], "'-1'"),
    "far too many seeds": (["sweep", "CartPole-v1", "--seeds", "0:999999999"], "--seeds"),
    "no steps": (["sweep", "CartPole-v1", "--steps", "0"], "--steps"),
    "malformed checkpoints": (["sweep", "CartPole-v1", "--checkpoints", "1k"], "5000,10000"),
    "late checkpoint": (["sweep", "CartPole-v1", "--checkpoints", "30000"], "from 1 to 20,000"),
    "no workers": (["sweep", "CartPole-v1", "--workers", "0"], "--workers"),
    "unknown cluster": (["sweep", "CartPole-v1", "--cluster", "slurm"], "dask"),
    "address of nothing": (["sweep", "CartPole-v1", "--address", "a:1"], "--cluster dask or ray"),
    "malformed address": (
        ["sweep", "CartPole-v1", "--cluster", "dask", "--address", "a"], "HOST:PORT",
    ),
    "nobody at the address": (
        ["sweep", "CartPole-v1", "--cluster", "ray", "--address", "127.0.0.1:1"],
        "There is no cluster at 127.0.0.1:1: Connection refused",
    ),
    "wrong suffix": (["sweep", "CartPole-v1", "--out", "r.csv"], ".parquet"),
    "out is a folder": (["sweep", "CartPole-v1", "--out", "folder.parquet"], "is a folder"),
    "out below a file": (["sweep", "CartPole-v1", "--out", "file.parquet/r.parquet"], "file.parq"),
    "out is no table": (["sweep", "CartPole-v1", "--out", "file.parquet"], "no sound Parquet file"),
    "missing table": (["results", "nowhere.parquet"], "nowhere.parquet"),
    "no table": (["results", "file.parquet"], "no sound Parquet file"),
    "page of another kind": (["results", "file.parquet", "--markdown", "a.txt"], ".md"),
    "plot of another kind": (["results", "file.parquet", "--plot", "a.png"], ".html"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_wrong_use_gets_one_line_before_anything_is_run(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    name: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.parquet").mkdir()
    (tmp_path / "file.parquet").write_text("hello")
    arguments, expected = WRONG[name]
    code = main(arguments)
    shown = capsys.readouterr()
    done = subprocess.CompletedProcess(arguments, code, shown.out, shown.err)
    assert_one_clear_line(done, expected)
    assert (tmp_path / "file.parquet").read_text() == "hello"


def test_a_folder_that_cannot_be_written_to_is_told(cli: Cli) -> None:
    if not Path("/proc").is_dir():
        pytest.skip("There is no folder here that even root cannot write to.")
    assert_one_clear_line(cli("sweep", "CartPole-v1", "--out", "/proc/r.parquet"), "/proc")


def test_a_page_without_a_place_for_tables_is_left_alone(cli: Cli, tmp_path: Path) -> None:
    assert cli("sweep", "CartPole-v1", "--seeds", "0", *SMALL).returncode == 0
    (tmp_path / "page.md").write_text("mine\n")
    done = cli("results", "r.parquet", "--markdown", "page.md")
    assert_one_clear_line(done, "page.md: Expected a line that says where the tables go")
    assert (tmp_path / "page.md").read_text() == "mine\n"


@pytest.mark.parametrize(
    ("library", "extra", "command"),
    [
        ("pyarrow", "experiments", ("sweep", "CartPole-v1")),
        ("scipy", "experiments", ("results", "r.parquet")),
        ("distributed", "dask", ("sweep", "CartPole-v1", "--cluster", "dask")),
        ("ray", "ray", ("sweep", "CartPole-v1", "--cluster", "ray")),
    ],
)
def test_a_missing_library_is_told_with_the_way_to_get_it(
    cli: Cli, tmp_path: Path, library: str, extra: str, command: tuple[str, ...]
) -> None:
    (tmp_path / f"{library}.py").write_text("raise ModuleNotFoundError('it is not there')")
    done = cli(*command)
    assert_one_clear_line(done, f"needs {library}")
    assert f"pip install 'ao2viz[{extra}]'" in done.stderr


def test_everything_else_works_without_those_libraries(cli: Cli, tmp_path: Path) -> None:
    for library in ("joblib", "pyarrow", "scipy", "distributed", "ray"):
        (tmp_path / f"{library}.py").write_text("raise ModuleNotFoundError('it is not there')")
    assert cli("train", "CartPole-v1", "--steps", "300", "--out", "a.ao2").returncode == 0
    assert cli("evaluate", "a.ao2", "--episodes", "1").returncode == 0
    assert cli("sweep", "--help").returncode == 0
