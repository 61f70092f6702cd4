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
    time.sleep(after_s)
    assert process.poll() is None, process.communicate()
    process.send_signal(number)
    return process.communicate(timeout=TIMEOUT_S)
