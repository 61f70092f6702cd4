"""Agent files: write, read, list. Writing is all or nothing; reading believes nothing."""

import contextlib
import dataclasses
import datetime
import io
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import make_config
from ao2viz.envs.motion import check_smoothing
from ao2viz.recording.growth_log import PREFIX, GrowthLog
from ao2viz.store.archive import MAX_STRANGE_BYTES, ArchiveReader, ArchiveWriter
from ao2viz.store.episodes import episode_from_arrays, episode_to_arrays
from ao2viz.store.errors import AgentFileError
from ao2viz.store.manifest import Manifest, from_json, to_json
from ao2viz.store.replacing import replacing
from ao2viz.store.saved import SavedAgent

SUFFIX = ".ao2"
_GROWTH_TYPES = {"step": "int64", "kind": "int8", "option": "int32", "parent": "int32"}

AnyPath = str | os.PathLike[str]


@dataclass(frozen=True)
class Summary:
    """What a list shows of an agent file, sound or not."""

    path: Path
    size: int  # Bytes.
    error: str = ""  # Why it cannot be opened; then the rest is empty.
    env_id: str = ""
    title: str = ""
    preset: str = ""
    seed: int = 0
    n_steps: int = 0
    n_options: int = 0
    n_episodes: int = 0  # Recorded ones.
    mean_return: float | None = None  # Of the latest up to 100 training episodes.
    created_at: str = ""


def write(path: AnyPath, saved: SavedAgent) -> Path:
    """Writes an agent; a kill at any moment leaves the old file or the new one whole.

    The folder is made if it is missing. A kill can leave a hidden `.tmp` file beside.

    Raises:
        OSError: If it cannot be written; an old file then is as it was.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as stream:
        _write_to(stream, saved)
    return path


def read(path: AnyPath) -> SavedAgent:
    """Reads an agent, all of it checked.

    Raises:
        AgentFileError: If it is no sound agent file; one line that says what is wrong.
    """
    with _opened(path) as archive:
        return _read_from(archive)


def keep(path: AnyPath, content: bytes) -> SavedAgent:
    """Checks all of what a stranger sent, as `read` does, then writes it as it came.

    Raises:
        AgentFileError: If it is no sound agent file; then nothing is written.
        OSError: If it cannot be written; an old file then is as it was.
    """
    path = Path(path)
    try:
        with ArchiveReader(io.BytesIO(content), MAX_STRANGE_BYTES) as archive:
            saved = _read_from(archive)
    except AgentFileError as error:
        raise AgentFileError(f"Could not open {path.name!r}. {error}") from error
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as stream:
        stream.write(content)
    return saved


def _read_from(archive: ArchiveReader) -> SavedAgent:
    manifest = from_json(archive.read_manifest())
    return _assemble(manifest, archive.read_arrays(manifest.members))


def summary(path: AnyPath) -> Summary:
    """What the manifest says; the arrays are not read.

    Raises:
        AgentFileError: If it is no agent file.
    """
    with _opened(path) as archive:
        manifest = from_json(archive.read_manifest())
    return Summary(
        path=Path(path),
        size=Path(path).stat().st_size,
        env_id=manifest.spec.env_id,
        title=manifest.spec.title,
        preset=manifest.preset.value,
        seed=manifest.seed,
        n_steps=manifest.n_steps,
        n_options=manifest.n_options,
        n_episodes=len(manifest.episodes),
        mean_return=manifest.mean_return,
        created_at=manifest.created_at,
    )


def list_agents(folder: AnyPath) -> list[Summary]:
    """Every .ao2 file of a folder by name, broken ones with their error; none if it is missing."""
    folder = Path(folder)
    if not folder.is_dir():
        return []
    return [
        _summary_or_error(path)
        for path in sorted(folder.glob(f"*{SUFFIX}"))
        if path.is_file() and not path.name.startswith(".")
    ]


def _summary_or_error(path: Path) -> Summary:
    try:
        return summary(path)
    except AgentFileError as error:
        return Summary(path, path.stat().st_size if path.exists() else 0, error=str(error))


@contextlib.contextmanager
def _opened(path: AnyPath) -> Iterator[ArchiveReader]:
    """The archive of a file; whatever goes wrong inside names the file."""
    path = Path(path)
    try:
        with open(path, "rb") as stream, ArchiveReader(stream) as archive:
            yield archive
    except FileNotFoundError:
        raise AgentFileError(f"There is no file {str(path)!r}.") from None
    except OSError as error:
        raise AgentFileError(f"Could not read {str(path)!r}: {error.strerror}.") from error
    except AgentFileError as error:
        raise AgentFileError(f"Could not open {str(path)!r}. {error}") from error


def _write_to(stream: IO[bytes], saved: SavedAgent) -> None:
    archive = ArchiveWriter(stream)
    for name, array in saved.state.items():
        archive.add(f"learner/{name}.npy", array)
    archive.add("history.npy", saved.history)
    for name, array in saved.growth.items():
        archive.add(f"growth/{name}.npy", array)
    for i, episode in enumerate(saved.episodes):
        for name, array in episode_to_arrays(episode, saved.spec).items():
            archive.add(f"episodes/{i}/{name}.npy", array)
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    archive.finish(to_json(saved, archive.members, now))


def _assemble(manifest: Manifest, arrays: Mapping[str, NDArray]) -> SavedAgent:
    saved = SavedAgent(
        spec=manifest.spec,
        config=make_config(manifest.preset, manifest.settings),
        seed=manifest.seed,
        n_steps=manifest.n_steps,
        state=_folder(arrays, "learner/"),
        generator=manifest.generator,
        history=_history(arrays),
        growth=_growth(_folder(arrays, "growth/"), manifest.growth_dropped),
        growth_dropped=manifest.growth_dropped,
        episodes=(),
        created_at=manifest.created_at,
        versions=manifest.versions,
    )
    n_rows = len(saved.forest_view().parents)
    if len(saved.forest_view()) != manifest.n_options:
        raise AgentFileError(
            f"Expected {manifest.n_options} options, but there are {len(saved.forest_view())}."
        )
    folders = {name.split("/")[1] for name in arrays if name.startswith("episodes/")}
    if folders != {str(i) for i in range(len(manifest.episodes))}:
        raise AgentFileError("Expected arrays for exactly the recorded episodes.")
    smoothing = saved.config.action_smoothing
    try:
        check_smoothing(manifest.spec, smoothing)
    except ValueError as error:
        raise AgentFileError(f"A setting does not fit: {error}") from error
    episodes = tuple(
        episode_from_arrays(
            header, _folder(arrays, f"episodes/{i}/"), manifest.spec, n_rows, smoothing
        )
        for i, header in enumerate(manifest.episodes)
    )
    return dataclasses.replace(saved, episodes=episodes)


def _folder(arrays: Mapping[str, NDArray], prefix: str) -> dict[str, NDArray]:
    return {
        name.removeprefix(prefix).removesuffix(".npy"): array
        for name, array in arrays.items()
        if name.startswith(prefix)
    }


def _history(arrays: Mapping[str, NDArray]) -> NDArray[np.float64]:
    history = arrays.get("history.npy")
    if history is None or history.dtype != np.float64 or history.shape[1:] != (4,):
        raise AgentFileError("Expected the training history as float64 with four columns.")
    if not np.isfinite(history).all() or (history[:, [0, 2, 3]] < 0).any():
        raise AgentFileError("Expected finite numbers in the training history.")
    return history


def _growth(arrays: dict[str, NDArray], dropped: int) -> dict[str, NDArray]:
    events = {name: array for name, array in arrays.items() if not name.startswith(PREFIX)}
    types = {name: array.dtype.name for name, array in events.items()}
    if types != _GROWTH_TYPES:
        raise AgentFileError(f"Expected the growth log as {_GROWTH_TYPES}, but it is {types}.")
    try:
        GrowthLog.from_arrays(arrays, dropped)
    except ValueError as error:
        raise AgentFileError(str(error)) from error
    return arrays
