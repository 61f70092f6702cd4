"""`ao2viz export` as people run it."""

import json
import signal
import time
from pathlib import Path

import pytest

from ao2viz.exports.formats import ABOUT
from ao2viz.resources import saved_schemas
from tests.cli.processes import Cli, interrupt, start
from tests.cli.test_bad_input import assert_one_clear_line

SHIPPED = str(saved_schemas() / "CartPole-v1.ao2")


def test_an_export_is_named_after_the_agent_and_says_where_it_is(cli: Cli, tmp_path: Path) -> None:
    done = cli("export", SHIPPED, "--format", "json")
    assert done.returncode == 0, done.stderr
    path = tmp_path / "CartPole-v1.json"
    assert done.stdout == f"Wrote CartPole-v1.json (json, {path.stat().st_size:,} bytes).\n"
    assert len(json.loads(path.read_text("utf-8"))["episodes"]) == 2


def test_json_tells_a_program_what_was_written(cli: Cli, tmp_path: Path) -> None:
    done = cli(
        *("export", SHIPPED, "--format", "paths-csv", "--episode", "1", "--out", "new/p.csv"),
        "--json",
    )
    told = json.loads(done.stdout)
    size = (tmp_path / "new" / "p.csv").stat().st_size
    assert told == {"file": "new/p.csv", "format": "paths-csv", "bytes": size}


def test_what_cannot_be_gets_one_line_and_leaves_nothing(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("mine")
    for arguments, words in (
        (["--format", "jsno"], "json"),
        ([], "--format"),
        (["--format", "csv", "--episode", "7"], "episodes 0 to 1"),
        (["--format", "csv", "--episode", "-1"], "--episode"),
        (["--format", "csv", "--out", "mine.csv"], "is there already"),
        (["--format", "csv", "--out", "/proc/x.csv"], "/proc"),
    ):
        assert_one_clear_line(cli("export", SHIPPED, *arguments), words)
    assert_one_clear_line(cli("export", "nowhere.ao2", "--format", "csv"), "nowhere.ao2")
    assert [path.name for path in tmp_path.iterdir()] == ["mine.csv"]
    assert (tmp_path / "mine.csv").read_text() == "mine"


def test_overwrite_replaces(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("mine")
    done = cli("export", SHIPPED, "--format", "csv", "--out", "mine.csv", "--overwrite")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "mine.csv").stat().st_size > 100_000


@pytest.mark.parametrize(("format", "after_s"), [("gif", 1.0), ("html", 0.0)])
def test_ctrl_c_in_the_middle_leaves_what_was_there(
    tmp_path: Path, format: str, after_s: float
) -> None:
    (tmp_path / "out").write_text("mine")
    process = start(tmp_path, "export", SHIPPED, "--format", format, "--out", "out", "--overwrite")
    while not (begun := list(tmp_path.glob(".out.*.tmp"))) and process.poll() is None:
        time.sleep(0.02)
    assert begun, process.communicate()
    output, errors = interrupt(process, after_s, signal.SIGINT)
    assert process.returncode == 130
    assert (output, errors) == ("", "Error: Interrupted.\n")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert (tmp_path / "out").read_text() == "mine"


def test_the_help_says_what_every_format_holds(cli: Cli) -> None:
    shown = " ".join(cli("export", "--help").stdout.split())
    for format, about in ABOUT.items():
        assert f"{format.value}: {about.holds}" in shown
