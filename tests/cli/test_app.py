"""`ao2viz app`, its short forms and `app.py`: each serves a page until Ctrl-C."""

import re
import signal
import socket
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest

from ao2viz.cli.entry import with_default_command
from ao2viz.resources import saved_schemas
from tests.cli.processes import ROOT, TIMEOUT_S, environment, start

BUNDLED = saved_schemas() / "CartPole-v1.ao2"  # It has recorded episodes.


def open_page(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Waits for the address in the terminal and fetches it; that line and the page."""
    assert process.stdout is not None
    line = process.stdout.readline()
    address = re.search(r"http://\S+", line)
    assert address is not None, process.communicate(timeout=TIMEOUT_S)
    with urllib.request.urlopen(address[0], timeout=30) as answer:
        return line, answer.read().decode()


def stop(process: subprocess.Popen[str]) -> str:
    """What Ctrl-C does; what was printed until then."""
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, errors
    assert "Traceback" not in errors
    return output


@pytest.mark.parametrize("command", [["app"], []], ids=["app", "no command"])
def test_the_dashboard_answers_and_stops_cleanly(tmp_path: Path, command: list[str]) -> None:
    process = start(tmp_path, *command, "--port", "0", "--no-browser")
    line, page = open_page(process)
    assert "127.0.0.1" in line or "localhost" in line
    assert "<html" in page.lower()
    assert "Stopped." in stop(process)


def test_an_agent_file_alone_opens_the_dashboard_on_it(tmp_path: Path, agent_file: Path) -> None:
    process = start(tmp_path, str(agent_file), "--port", "0", "--no-browser")
    line, _ = open_page(process)
    assert "agent.ao2" in line
    stop(process)


def test_app_py_starts_the_same_dashboard_from_any_folder(tmp_path: Path, agent_file: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, ROOT / "app.py", agent_file, "--port", "0", "--no-browser"],
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    line, page = open_page(process)
    assert "agent.ao2" in line
    assert "<html" in page.lower()
    stop(process)


def test_a_taken_port_is_passed_over_and_said(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        process = start(tmp_path, "app", "--port", str(port), "--no-browser")
        line, _ = open_page(process)
        assert f":{port}/" not in line
        assert process.stdout is not None
        assert f"port {port} was taken" in process.stdout.readline()
        stop(process)


def test_what_is_not_a_command_opens_the_dashboard() -> None:
    assert with_default_command([]) == ["app"]
    assert with_default_command(["a.ao2", "--port", "1"]) == ["app", "a.ao2", "--port", "1"]
    assert with_default_command(["--no-browser"]) == ["app", "--no-browser"]
    for arguments in (["--help"], ["--version"], ["train", "--help"], ["trian"], ["info", "a.ao2"]):
        assert with_default_command(arguments) == arguments


def test_the_dashboard_opens_at_a_moment(tmp_path: Path) -> None:
    moment = ("--episode", "0", "--step", "1")
    process = start(tmp_path, str(BUNDLED), *moment, "--port", "0", "--no-browser")
    open_page(process)
    stop(process)


@pytest.mark.parametrize(
    ("moment", "words"),
    [
        (("--episode", "77"), "There is no recorded episode 77"),
        (("--step", "99999"), "There is no step 99999 in that episode"),
        (("--step", "-1"), "Invalid value"),
    ],
)
def test_a_moment_that_is_not_there_is_said_in_the_terminal(
    tmp_path: Path, moment: tuple[str, ...], words: str
) -> None:
    process = start(tmp_path, str(BUNDLED), *moment, "--port", "0", "--no-browser")
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 2
    assert words in errors
    assert "Traceback" not in errors
