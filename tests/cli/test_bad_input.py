"""Whatever is asked wrongly gets one clear line, exit code 2 and no traceback."""

import io
import zipfile
from pathlib import Path

import pytest

from ao2viz.cli.console import say_error
from tests.cli.processes import Cli

WRONG = {
    "no such command": (["trian"], "trian"),
    "no such option": (["train", "CartPole-v1", "--sed", "3"], "--seed"),
    "missing argument": (["train"], "ENV"),
    "missing file argument": (["info"], "FILE"),
    "not a number": (["train", "CartPole-v1", "--steps", "many"], "--steps"),
    "out of range": (["train", "CartPole-v1", "--steps", "0"], "--steps"),
    "negative seed": (["evaluate", "a.ao2", "--seed", "-1"], "--seed"),
    "no episodes": (["evaluate", "a.ao2", "--episodes", "0"], "--episodes"),
    "unknown preset": (["train", "CartPole-v1", "--preset", "papr"], "anticipating"),
    "unknown environment": (["train", "CartPol-v1"], "CartPole-v1"),
    "environment that does not fit": (["train", "Blackjack-v1"], "one-dimensional Box"),
    "unknown setting": (["train", "CartPole-v1", "--set", "lvels=3"], "Did you mean 'levels'"),
    "setting out of range": (["train", "CartPole-v1", "--set", "levels=99"], "between 0 and 12"),
    "setting of a wrong kind": (["train", "CartPole-v1", "--set", "levels=x"], "levels"),
    "discrete actions to smooth": (
        ["train", "CartPole-v1", "--set", "action_smoothing=0.9"],
        "mean",
    ),
    "setting without value": (["train", "CartPole-v1", "--set", "levels"], "NAME=VALUE"),
    "setting that is an option": (["train", "CartPole-v1", "--set", "seed=1"], "--seed"),
    "wrong suffix": (["train", "CartPole-v1", "--out", "agent.zip"], ".ao2"),
    "out is a folder": (["train", "CartPole-v1", "--out", "folder.ao2"], "folder"),
    "out below a file": (["train", "CartPole-v1", "--out", "file.txt/a.ao2"], "file.txt"),
    "missing file": (["info", "nowhere.ao2"], "nowhere.ao2"),
    "missing file to evaluate": (["evaluate", "nowhere.ao2"], "nowhere.ao2"),
    "missing file to record": (["record", "nowhere.ao2"], "nowhere.ao2"),
    "missing file to show": (["app", "nowhere.ao2", "--no-browser"], "nowhere.ao2"),
    "missing file to show, in short": (["nowhere.ao2"], "nowhere.ao2"),
    "a folder for a file": (["info", "folder.ao2"], "folder.ao2"),
    "not an agent": (["info", "file.txt"], "file.txt"),
    "no such folder": (["list", "nowhere"], "nowhere"),
    "port out of range": (["app", "--port", "70000"], "--port"),
    "curves that are none": (
        ["app", "--no-browser", "--curves", "file.txt"],
        "file.txt is no curves.json",
    ),
    "missing curves": (["app", "--no-browser", "--curves", "nowhere.json"], "nowhere.json"),
}


def assert_one_clear_line(done, expected: str) -> None:
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("Error: ")
    assert expected in lines[0]
    assert "Value error" not in lines[0]


@pytest.mark.parametrize("name", WRONG)
def test_wrong_use_gets_one_line(cli: Cli, tmp_path: Path, name: str) -> None:
    (tmp_path / "folder.ao2").mkdir()
    (tmp_path / "file.txt").write_text("hello")
    arguments, expected = WRONG[name]
    assert_one_clear_line(cli(*arguments), expected)


def test_an_unwritable_folder_is_told_before_anything_is_trained(cli: Cli) -> None:
    if not Path("/proc").is_dir():
        pytest.skip("There is no folder here that even root cannot write to.")
    done = cli("train", "CartPole-v1", "--steps", "100000000", "--out", "/proc/a.ao2")
    assert_one_clear_line(done, "/proc")


def _archive(members: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return buffer.getvalue()


HOSTILE = {
    "empty": b"",
    "empty archive": _archive({}),
    "no manifest": _archive({"a.npy": b"x"}),
    "manifest is no JSON": _archive({"manifest.json": b"{"}),
    "manifest of another kind": _archive({"manifest.json": b"[]"}),
    "very deep manifest": _archive({"manifest.json": b"[" * 100_000}),
    "leaves its folder": _archive({"manifest.json": b"{}", "../../escaped": b"x"}),
    "a pickle in disguise": _archive({"manifest.json": b"cos\nsystem\n(S'touch owned'\ntR."}),
}


@pytest.mark.parametrize("command", ["info", "evaluate", "record"])
@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_gets_one_line_and_does_nothing(
    cli: Cli, tmp_path: Path, name: str, command: str
) -> None:
    (tmp_path / "bad.ao2").write_bytes(HOSTILE[name])
    assert_one_clear_line(cli(command, "bad.ao2"), "bad.ao2")
    assert {path.name for path in tmp_path.iterdir()} == {"bad.ao2"}
    assert (tmp_path / "bad.ao2").read_bytes() == HOSTILE[name]


@pytest.mark.parametrize("cut", [0.1, 0.5, 0.99])
def test_a_file_cut_short_gets_one_line(
    cli: Cli, agent_file: Path, tmp_path: Path, cut: float
) -> None:
    content = agent_file.read_bytes()
    (tmp_path / "cut.ao2").write_bytes(content[: int(cut * len(content))])
    assert_one_clear_line(cli("info", "cut.ao2"), "cut.ao2")


def test_control_characters_in_a_message_never_reach_the_terminal(
    capsys: pytest.CaptureFixture[str],
) -> None:
    say_error("first\nsecond \x1b[2Jthird [bold]fourth[/bold]")
    shown = capsys.readouterr().err
    assert shown == "Error: first second �[2Jthird [bold]fourth[/bold]\n"
