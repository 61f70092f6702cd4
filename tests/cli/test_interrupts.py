"""Ctrl-C, and other ways in which a long command may not end as it was meant to."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import ao2viz
from ao2viz import explanations
from ao2viz.cli import main
from ao2viz.cli.interrupts import DeferredInterrupts
from ao2viz.resources import saved_schemas
from tests.cli.processes import ROOT, TIMEOUT_S, environment, interrupt, start

FOREVER = ("--steps", "100000000")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_saves_what_was_learned_and_says_where(
    tmp_path: Path, agent_file: Path, number: signal.Signals, code: int
) -> None:
    # `agent_file` has compiled, so four seconds of work are enough to be in the middle of learning.
    process = start(tmp_path, "train", "CartPole-v1", *FOREVER, "--out", "a.ao2")
    output, errors = interrupt(process, 4, number)
    assert process.returncode == code
    assert "Traceback" not in errors
    assert "saved to a.ao2" in errors
    assert "Saved to a.ao2" in output
    agent = ao2viz.AO2.load(tmp_path / "a.ao2")
    assert 0 < agent.num_timesteps < 100_000_000
    agent.learn(10)  # And it can go on.


def test_what_cannot_be_saved_where_it_should_is_saved_elsewhere(
    tmp_path: Path, agent_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.setenv("TMPDIR", str(elsewhere))
    process = start(tmp_path, "train", "CartPole-v1", *FOREVER, "--out", "folder/a.ao2")
    while not (tmp_path / "folder").is_dir() and process.poll() is None:
        pass
    time.sleep(3)  # The folder is tried out before training begins; only then it goes away.
    (tmp_path / "folder").rename(tmp_path / "moved")
    (tmp_path / "folder").write_text("in the way")
    output, errors = interrupt(process, 4)
    (saved,) = elsewhere.glob("*/a.ao2")
    assert "Could not save to folder/a.ao2" in errors
    assert str(saved) in errors
    assert str(saved) in output
    assert ao2viz.AO2.load(saved).num_timesteps > 0


def test_an_interrupted_evaluation_says_so_in_one_line(tmp_path: Path, agent_file: Path) -> None:
    process = start(tmp_path, "evaluate", str(agent_file), "--episodes", "100000000")
    output, errors = interrupt(process, 4)
    assert process.returncode == 130
    assert (output, errors) == ("", "Error: Interrupted.\n")


@pytest.mark.parametrize("module", ["typer", "numba"])  # The first and the last to be imported.
@pytest.mark.parametrize(
    "program",
    [
        ("-m", "ao2viz"),
        ("-c", "import sys; from ao2viz.cli import main; sys.exit(main())"),  # As pip writes it.
        (str(ROOT / "app.py"),),
    ],
    ids=["module", "installed", "app.py"],
)
def test_an_interrupt_while_importing_says_so_in_one_line(
    tmp_path: Path, program: tuple[str, ...], module: str
) -> None:
    # Found before the real one, and presses Ctrl-C while it is imported.
    (tmp_path / f"{module}.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\n")
    ended = subprocess.run(
        [sys.executable, *program, "--port", "0", "--no-browser"],
        cwd=tmp_path,
        env=environment(tmp_path),
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, "", "Error: Interrupted.\n")


def test_the_second_interrupt_does_not_wait() -> None:
    told: list[str] = []
    with DeferredInterrupts(lambda: told.append("once")) as interrupts:
        assert interrupts.exit_code == 0
        signal.raise_signal(signal.SIGINT)
        assert interrupts.received is signal.SIGINT
        assert interrupts.exit_code == 130
        with pytest.raises(KeyboardInterrupt, match=r"^$"):
            signal.raise_signal(signal.SIGINT)
    assert told == ["once"]


def test_afterwards_ctrl_c_works_as_before() -> None:
    before = signal.getsignal(signal.SIGINT)
    with DeferredInterrupts(lambda: None):
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before


def test_learning_again_is_ended_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def press_in_the_middle(*_, on_progress: Callable[[float], None], **__) -> None:
        on_progress(0.3)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(explanations, "learn_again", press_in_the_middle)
    file = str(saved_schemas() / "CartPole-v1.ao2")
    assert main(["explain", file, "forget", "--forget", "2"]) == 130
    printed = capsys.readouterr()
    assert printed.out == ""
    told = "Called off in the middle of learning again: there is no answer."
    assert printed.err.splitlines() == [told]
