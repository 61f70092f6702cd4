"""Checks on the files a command is to write, before any work is done for them."""

import tempfile
from pathlib import Path

from ao2viz.store.replacing import replacing

RUNS_FOLDER = Path("runs")
"""Where agents go, and are looked for, if nothing else is said; below the working folder."""


def check_output(path: Path, *, overwrite: bool) -> None:
    """Makes the folder, and makes sure that saving to the path will not fail later.

    Raises:
        ValueError: If there is a file already and `overwrite` is False, or the name does not fit.
        OSError: If the folder cannot be made or written to.
    """
    check_name(path, ".ao2")
    if path.exists() and not overwrite:
        raise ValueError(f"{path} is there already; name another file or add --overwrite.")
    check_folder(path)


def check_name(path: Path, suffix: str) -> None:
    """Makes sure that a path can be that of a file of its kind.

    Raises:
        ValueError: If it ends otherwise, or is a folder.
    """
    if path.suffix != suffix:
        raise ValueError(f"Expected a file name that ends in {suffix}, but got {path}.")
    if path.is_dir():
        raise ValueError(f"{path} is a folder; name a file in it.")


def check_folder(path: Path) -> None:
    """Makes the folder of a file, and makes sure that it can be written to.

    Raises:
        OSError: If not.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        # Permissions alone do not tell: root may everything, and still not write everywhere.
        with tempfile.NamedTemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise OSError(error.errno, "Cannot write to this folder", str(path.parent)) from error


def write_text(path: Path, text: str) -> None:
    """Writes a page whole or, on an error, not at all.

    Raises:
        OSError: If it cannot be written; an old one then is as it was.
    """
    with replacing(path) as stream:
        stream.write(text.encode())
