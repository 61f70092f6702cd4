"""Checks on the files a command is to write, before any work is done for them."""

import tempfile
from pathlib import Path

RUNS_FOLDER = Path("runs")
"""Where agents go, and are looked for, if nothing else is said; below the working folder."""


def check_output(path: Path, *, overwrite: bool) -> None:
    """Makes the folder, and makes sure that saving to the path will not fail later.

    Raises:
        ValueError: If there is a file already and `overwrite` is False, or the name does not fit.
        OSError: If the folder cannot be made or written to.
    """
    if path.suffix != ".ao2":
        raise ValueError(f"Expected a file name that ends in .ao2, but got {path}.")
    if path.is_dir():
        raise ValueError(f"{path} is a folder; name a file in it.")
    if path.exists() and not overwrite:
        raise ValueError(f"{path} is there already; name another file or add --overwrite.")
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        # Permissions alone do not tell: root may everything, and still not write everywhere.
        with tempfile.NamedTemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise OSError(error.errno, "Cannot write to this folder", str(path.parent)) from error
