"""`ao2viz app`: the dashboard, on an agent of one's own or a bundled one."""

from collections.abc import Sequence
from pathlib import Path

from ao2viz.cli.console import say
from ao2viz.cli.files import RUNS_FOLDER
from ao2viz.store.files import read


def run(
    file: Path | None, *, host: str, port: int, open_browser: bool, folders: Sequence[Path] = ()
) -> None:
    """Serves until Ctrl-C; agents go to the first folder unless another is chosen.

    Raises:
        ValueError: If the file is no agent, or a folder is something else.
        OSError: If it cannot be read, or the address cannot be listened on.
    """
    if file is not None:
        read(file)  # A broken file is told here, in the terminal, before any page opens.
    allowed = [folder.resolve() for folder in folders] or [RUNS_FOLDER.resolve()]
    for folder in allowed:
        if folder.exists() and not folder.is_dir():
            raise ValueError(f"Expected --folder to be a folder, but {folder} is something else.")
    from ao2viz.ui.app import serve  # noqa: PLC0415 -- heavy.

    try:
        serve(file, host, port, open_browser, folder=allowed[0], more_folders=tuple(allowed[1:]))
    except KeyboardInterrupt:
        say("Stopped.")
