"""One writer at a time: a lock that the operating system takes back whatever happens to us."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows; there, two sweeps into one table are left to people's care.
    fcntl = None


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Holds a lock beside a file, which itself is replaced with every write.

    Raises:
        ValueError: If another process holds it.
        OSError: If the folder cannot be written to.
    """
    if fcntl is None:
        yield
        return
    beside = path.with_name(f".{path.name}.lock")
    handle = _take(beside)
    while not _is_there(beside, handle):  # Who held it last removed it after we had opened it.
        os.close(handle)
        handle = _take(beside)
    try:
        yield
    finally:
        beside.unlink(missing_ok=True)
        os.close(handle)


def _take(path: Path) -> int:
    assert fcntl is not None
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(handle)
        if not isinstance(error, BlockingIOError):
            raise
        table = path.name.removeprefix(".").removesuffix(".lock")
        raise ValueError(
            f"Another sweep is writing to {table}. Wait for it, or name another table."
        ) from None
    return handle


def _is_there(path: Path, handle: int) -> bool:
    try:
        return os.path.samestat(os.stat(path), os.fstat(handle))
    except FileNotFoundError:
        return False
