"""`ao2viz app`: the dashboard, on an agent of one's own or a bundled one."""

from pathlib import Path

from ao2viz.cli.console import say
from ao2viz.cli.files import RUNS_FOLDER
from ao2viz.store.files import read


def run(file: Path | None, *, host: str, port: int, open_browser: bool) -> None:
    """Serves until Ctrl-C.

    Raises:
        ValueError: If the file is no agent.
        OSError: If it cannot be read, or the address cannot be listened on.
    """
    if file is not None:
        read(file)  # A broken file is told here, in the terminal, before any page opens.
    from ao2viz.ui.app import serve  # noqa: PLC0415 -- heavy.

    try:
        serve(file, host, port, open_browser, folder=RUNS_FOLDER.resolve())
    except KeyboardInterrupt:
        say("Stopped.")
