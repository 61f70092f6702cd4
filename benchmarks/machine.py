"""What a table of measurements must say about where it comes from."""

import math
import os
import platform
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np


def describe_run(module: str) -> str:
    """The command, the commit and the machine, in two lines of Markdown."""
    command = " ".join(["python -m", module, *sys.argv[1:]])
    return (
        f"`{command}` at commit {_commit()}\n{_processor()}, {os.cpu_count()} cores, "
        f"{platform.system()}, Python {platform.python_version()}, NumPy {np.__version__}, "
        f"Numba {numba.__version__}"
    )


def processor_s(place: str | Path) -> float:
    """Processor time that a process or thread has used so far, by its folder in /proc; else NaN."""
    try:
        # proc(5): fields 14 and 15, counted after the name in parentheses, in clock ticks.
        fields = (Path(place) / "stat").read_text().rpartition(")")[2].split()
    except OSError:
        return math.nan
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _commit() -> str:
    root = Path(__file__).resolve().parent.parent
    git = ["git", "-C", str(root)]
    try:
        commit = subprocess.check_output([*git, "rev-parse", "--short", "HEAD"], text=True).strip()
        changed = subprocess.check_output(
            [*git, "status", "--porcelain", "--untracked-files=no", "--", "ao2viz"], text=True
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return f"{commit}, with changes" if changed else commit


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
