import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.processes import TIMEOUT_S, Cli, environment, start


@pytest.fixture
def cli(tmp_path: Path) -> Cli:
    """Runs a command in an empty folder of its own, to its end."""

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "ao2viz", *arguments],
            check=False,
            cwd=tmp_path,
            env=environment(tmp_path),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
        )

    return run


@pytest.fixture(scope="session")
def agent_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An agent that the command line has trained a little; not to be written to."""
    folder = tmp_path_factory.mktemp("agent")
    process = start(folder, "train", "CartPole-v1", "--steps", "1500", "--out", "agent.ao2")
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, errors
    return folder / "agent.ao2"
