"""The shelf of agent files, and those that were opened."""

from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from ao2viz.explain.words import count
from ao2viz.store.errors import AgentFileError
from ao2viz.store.files import SUFFIX, keep, read, summary
from ao2viz.store.saved import SavedAgent
from ao2viz.ui.downloads import Notify
from ao2viz.ui.session import Upload
from ao2viz.ui.world import LoadFailure, ShelfItem

Stamp = tuple[int, int] | None
"""Tells versions of a file apart: when it was written and its size; None if it is missing."""


class Library:
    """Lists agent files and opens them in a thread of its own."""

    def __init__(
        self, shipped: Path, folder: Path, extra: Path | None = None, more: tuple[Path, ...] = ()
    ) -> None:
        """Makes a library.

        Args:
            shipped: The folder of the agents that come with the app.
            folder: Where people save agents.
            extra: A file from anywhere, put first.
            more: Further folders that people may save to.
        """
        self._shipped, self._folders, self.extra = shipped, (folder, *more), extra
        self._keeping: list[tuple[int, Future[Notify]]] = []
        self._opening: dict[Path, Future[SavedAgent]] = {}
        self._opened: dict[Path, SavedAgent | LoadFailure] = {}
        self._stamps: dict[Path, Stamp] = {}  # Of the opened files, when reading began.
        self._env_ids: dict[Path, tuple[Stamp, str]] = {}
        self._thread = ThreadPoolExecutor(1, "library")

    @property
    def opened(self) -> Mapping[Path, SavedAgent | LoadFailure]:
        """Files that are open or cannot be; one that is missing here is still being read."""
        return dict(self._opened)

    def shelf(self) -> tuple[ShelfItem, ...]:
        """Every file that can be watched: the given one, the shipped ones, the saved ones."""
        shipped = _agents_in(self._shipped)
        saved = [path for folder in self._folders for path in _agents_in(folder)]
        extra = [self.extra] if self.extra is not None else []
        paths = list(dict.fromkeys([*extra, *shipped, *saved]))
        labels: dict[str, Path] = {}
        for path in paths:
            label = path.stem
            if label in labels:  # A file of the same name in another folder.
                label = f"{label} ({path.parent.name})"
            number = 2
            while label in labels:
                label, number = f"{path.stem} ({number})", number + 1
            labels[label] = path
        return tuple(ShelfItem(path, label, self._env_id(path)) for label, path in labels.items())

    def _env_id(self, path: Path) -> str:
        """The task of a file, read anew only when the file has changed."""
        stamp, known = _stamp(path), self._env_ids.get(path)
        if known is None or known[0] != stamp:
            try:
                known = stamp, summary(path).env_id
            except (AgentFileError, OSError):
                known = stamp, ""
            self._env_ids[path] = known
        return known[1]

    def know(self, path: Path, saved: SavedAgent) -> None:
        """Takes over a file that somebody else has just read."""
        self._stamps[path] = _stamp(path)
        self._opening[path] = self._thread.submit(_prepare, saved)

    def open(self, path: Path) -> None:
        """Begins to read a file unless it is open already."""
        if path not in self._opened and path not in self._opening:
            self._stamps[path] = _stamp(path)
            self._opening[path] = self._thread.submit(_read, path)

    def forget_changed(self) -> bool:
        """Forgets files that were written since they were read; whether there was any."""
        # One that is gone is shown for as long as somebody watches it.
        changed = [p for p in self._opened if _stamp(p) not in {self._stamps[p], None}]
        for path in changed:
            del self._opened[path]
        return bool(changed)

    def poll(self) -> bool:
        """Takes over what has been read; whether there was anything."""
        done = [path for path, future in self._opening.items() if future.done()]
        for path in done:
            future = self._opening.pop(path)
            try:
                self._opened[path] = future.result()
            except (AgentFileError, OSError) as error:
                self._opened[path] = LoadFailure(f"Cannot open {path.name}: {error}")
            except Exception as error:  # A bug, not a broken file; still no reason to die.
                self._opened[path] = LoadFailure(
                    f"Cannot open {path.name}: {type(error).__name__}: {error}"
                )
        return bool(done)

    def keep(self, client_id: int, upload: Upload) -> None:
        """Begins to check an uploaded file, and to write it if it is an agent."""
        self._keeping.append((client_id, self._thread.submit(_keep, upload)))

    def poll_kept(self) -> list[tuple[int, Notify]]:
        """What became of uploads since the last call, and whose they were."""
        done = [each for each in self._keeping if each[1].done()]
        self._keeping = [each for each in self._keeping if each not in done]
        return [(client_id, future.result()) for client_id, future in done]

    def close(self) -> None:
        """Stops reading."""
        self._thread.shutdown(wait=True, cancel_futures=True)


def _agents_in(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    return sorted(p for p in folder.glob(f"*{SUFFIX}") if not p.name.startswith("."))


def _stamp(path: Path) -> Stamp:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


def _read(path: Path) -> SavedAgent:
    return _prepare(read(path))


def _prepare(saved: SavedAgent) -> SavedAgent:
    saved.forest_view()  # Cached: whatever is wrong with it shows up here, off the app loop.
    return saved


def _keep(upload: Upload) -> Notify:
    name = upload.path.name
    try:
        saved = keep(upload.path, upload.content)
    except (AgentFileError, OSError) as error:
        return Notify("Not uploaded", str(error), is_error=True)
    except Exception as error:  # A bug of ours; whoever sent the file is told all the same.
        return Notify("Not uploaded", f"{name}: {type(error).__name__}: {error}", is_error=True)
    return Notify("Uploaded", f"{name}: {saved.spec.env_id}, {count(saved.n_steps, 'step')}.")
