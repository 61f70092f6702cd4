"""Starts `ao2viz` as the process that people run."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TIMEOUT_S = 180  # Generous: on a fresh machine the first command compiles.

Cli = Callable[..., subprocess.CompletedProcess[str]]


def environment(*folders: Path) -> dict[str, str]:
    paths = os.pathsep.join(str(folder) for folder in (ROOT, *folders))
    return os.environ | {"PYTHONPATH": paths, "COLUMNS": "120", "NO_COLOR": "1"}


def start(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Starts a command in a folder; modules in that folder can be imported by it."""
    return subprocess.Popen(
        [sys.executable, "-m", "ao2viz", *arguments],
        cwd=folder,
        env=environment(folder),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def interrupt(
    process: subprocess.Popen[str], after_s: float, number: signal.Signals = signal.SIGINT
) -> tuple[str, str]:
    """Lets a command work for a while, then sends what Ctrl-C sends; its stdout and stderr."""
    begun = _worked_s(process)
    while process.poll() is None and _worked_s(process) < begun + after_s:
        time.sleep(0.02)
    assert process.poll() is None, process.communicate()
    process.send_signal(number)
    return process.communicate(timeout=TIMEOUT_S)


def _worked_s(process: subprocess.Popen[str]) -> float:
    """Seconds of processor time, which do not pass faster where the machine is busy."""
    told = Path(f"/proc/{process.pid}/stat")
    if not told.exists():
        return time.monotonic()
    # Behind the name, in brackets, the 12th and 13th number are ticks in user and system mode.
    ticks = told.read_text().rpartition(")")[2].split()[11:13]
    return sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")
