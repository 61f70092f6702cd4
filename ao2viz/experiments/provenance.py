"""Which code a figure was measured with."""

import functools
import subprocess
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

_PACKAGE = Path(__file__).resolve().parent.parent


class Provenance(NamedTuple):
    """The code that is running."""

    version: str  # Of ao2viz; "unknown" if it is not installed.
    commit: str | None  # Of its checkout, "+" behind it if changed since; None if there is none.

    def __str__(self) -> str:
        return f"ao2viz {self.version}" + (f" at commit {self.commit}" if self.commit else "")


@functools.cache
def provenance() -> Provenance:
    """That of this process, found out once."""
    try:
        version = metadata.version("ao2viz")
    except metadata.PackageNotFoundError:
        version = "unknown"
    return Provenance(version, _commit())


def _commit() -> str | None:
    # Installed somewhere below a checkout of something else, we would take its commit for ours.
    if not (_PACKAGE.parent / ".git").exists():
        return None
    git = ["git", "-C", str(_PACKAGE.parent)]
    try:
        commit = _ask([*git, "rev-parse", "--short=10", "HEAD"])
        changed = _ask([*git, "status", "--porcelain", "--untracked-files=no", "--", "ao2viz"])
    except (OSError, subprocess.SubprocessError):
        return None
    return f"{commit}+" if changed else commit


def _ask(command: list[str]) -> str:
    return subprocess.run(
        command, capture_output=True, check=True, text=True, timeout=10
    ).stdout.strip()
