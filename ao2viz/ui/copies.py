"""Agent files on their way to a browser."""

import contextlib
import re
import secrets
from pathlib import Path

from ao2viz.store.files import SUFFIX
from ao2viz.training.states import Save
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.downloads import Notify, SaveFile
from ao2viz.ui.shelf import MAX_UPLOAD_BYTES

_PATIENCE_S = 60.0


def read_agent(path: Path, name: str | None = None) -> SaveFile | Notify:
    """A file as it is sent; what can be downloaded can be uploaded again."""
    try:
        if path.stat().st_size > MAX_UPLOAD_BYTES:
            return Notify("Too big to download", f"Copy it from where it is: {path}", is_error=True)
        return SaveFile(name or path.name, path.read_bytes())
    except OSError as error:
        words = f"{path.name} cannot be read: {error.strerror or error}."
        return Notify("Not downloaded", words, is_error=True)


class Copies:
    """Copies of the agent of the run: asked of the worker, sent as soon as they are whole."""

    def __init__(self, folder: Path) -> None:
        """Makes none yet; they lie hidden in the folder for as long as it takes."""
        self._folder = folder
        self._wanted: dict[Path, tuple[int, str, float | None]] = {}

    def ask(self, client_id: int, update: RunUpdate) -> Save:
        """What to ask of the run for this browser."""
        env_id = update.spec.env_id if update.spec is not None else "agent"
        stem = re.sub(r"[^A-Za-z0-9.-]+", "_", f"{env_id}-{update.preset.value}").strip("_.-")
        path = self._folder / f".{secrets.token_hex(6)}.download{SUFFIX}"
        name = f"{stem}-seed{update.seed}-{update.n_steps}{SUFFIX}"
        self._wanted[path] = (client_id, name, None)
        return Save(path, is_copy=True)

    def poll(self, now: float) -> list[tuple[int, SaveFile | Notify]]:
        """The copies that are whole by now, and whose they are."""
        done: list[tuple[int, SaveFile | Notify]] = []
        for path, (client_id, name, since) in list(self._wanted.items()):
            if path.exists():  # Files take their name when they are whole.
                done.append((client_id, read_agent(path, name)))
                with contextlib.suppress(OSError):
                    path.unlink()
            elif since is None:
                self._wanted[path] = (client_id, name, now)
                continue
            elif now - since < _PATIENCE_S:
                continue
            else:
                words = "The run did not hand out its agent in time."
                done.append((client_id, Notify("Not downloaded", words, is_error=True)))
            del self._wanted[path]
        return done
