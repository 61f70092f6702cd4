"""Files of baselines: numbers as safetensors, and what they mean as JSON in its header.

Nothing in them is ever run, and nothing is believed before it is checked.
"""

import datetime
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from ao2viz.baselines.algorithm import Algorithm
from ao2viz.envs.task import TaskSpec
from ao2viz.recording.history import EpisodeSummary, History
from ao2viz.store.errors import AgentFileError, quote
from ao2viz.store.fields import Fields, parse_object
from ao2viz.store.manifest import library_versions
from ao2viz.store.replacing import replacing
from ao2viz.store.task import task_from_json, task_to_json

SUFFIX = ".safetensors"
FORMAT = "ao2viz-baseline"
FORMAT_VERSION = 1
MAX_FILE_BYTES = 512 * 2**20
_MAX_MANIFEST = 2**20
_MAX_TENSORS = 10_000
_NAME = re.compile(r"[\w.]{1,200}")
_DTYPES = {"F32": np.float32, "F64": np.float64, "I64": np.int64}


@dataclass(frozen=True, eq=False)
class SavedBaseline:
    """What a file holds, in memory."""

    algorithm: Algorithm
    spec: TaskSpec
    settings: Mapping[str, Any]
    seed: int
    n_steps: int
    tensors: Mapping[str, NDArray]


def write(path: str | os.PathLike[str], saved: SavedBaseline) -> None:
    """Writes a baseline; a kill at any moment leaves the old file or the new one whole.

    Raises:
        ValueError: If the name does not end in .safetensors.
        OSError: If it cannot be written.
    """
    path = Path(path)
    if path.suffix != SUFFIX:
        raise ValueError(f"Expected a file name that ends in {SUFFIX}, but got {str(path)!r}.")
    manifest = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "created_at": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "versions": library_versions(),
        "algorithm": saved.algorithm.value,
        "task": task_to_json(saved.spec),
        "settings": dict(saved.settings),
        "seed": saved.seed,
        "n_steps": saved.n_steps,
    }
    tensors = {name: np.require(array, requirements="C") for name, array in saved.tensors.items()}
    content = save(tensors, {FORMAT: json.dumps(manifest, allow_nan=False)})
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as stream:
        stream.write(content)


def read(path: str | os.PathLike[str]) -> SavedBaseline:
    """Reads a baseline; numbers are finite, and what they fit is checked by who takes them.

    Raises:
        AgentFileError: If it is no sound file of a baseline; one line that says what is wrong.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
        if size > MAX_FILE_BYTES:
            raise AgentFileError(
                f"Expected at most {MAX_FILE_BYTES:,} bytes, but there are {size:,}."
            )
        with safe_open(path, framework="numpy") as opened:
            return _read(opened)
    except FileNotFoundError:
        raise AgentFileError(f"There is no file {str(path)!r}.") from None
    except OSError as error:
        raise AgentFileError(f"Could not read {str(path)!r}: {error.strerror}.") from error
    except SafetensorError as error:
        raise AgentFileError(
            f"Could not open {str(path)!r}. Expected a safetensors file, but: {quote(error)}."
        ) from error
    except AgentFileError as error:
        raise AgentFileError(f"Could not open {str(path)!r}. {error}") from error


def take(tensors: Mapping[str, NDArray], name: str, like: NDArray) -> NDArray:
    """A tensor of a file, of the same shape and type as one that is there.

    Raises:
        AgentFileError: If it is missing or another.
    """
    found = tensors.get(name)
    if found is None or found.shape != like.shape or found.dtype != like.dtype:
        came = "is missing" if found is None else f"is {found.dtype} of shape {found.shape}"
        raise AgentFileError(
            f"Expected {quote(name)} to be {like.dtype} of shape {like.shape}, but it {came}."
        )
    return found


def to_history(tensors: Mapping[str, NDArray]) -> History:
    """The training episodes of a file.

    Raises:
        AgentFileError: If they are missing or no episodes.
    """
    rows = tensors.get("history", np.empty(0))
    columns = len(EpisodeSummary._fields)
    if rows.dtype != np.float64 or rows.shape[1:] != (columns,) or (rows[:, [0, 2, 3]] < 0).any():
        raise AgentFileError(f"Expected the training history as float64 with {columns} columns.")
    return History.from_array(rows)


def _read(opened: Any) -> SavedBaseline:
    metadata = opened.metadata() or {}
    text = metadata.get(FORMAT)
    if text is None or len(text) > _MAX_MANIFEST:
        raise AgentFileError("Expected a baseline of ao2viz, but the file does not say it is one.")
    manifest = Fields(parse_object(text.encode()), "manifest")
    if manifest.text("format") != FORMAT:
        raise AgentFileError(f"Expected the format {FORMAT!r}, not {quote(manifest.raw('format'))}")
    version = manifest.whole("format_version", 1)
    if version > FORMAT_VERSION:
        raise AgentFileError(
            f"This needs a newer ao2viz: its format is {version}, and {FORMAT_VERSION} is the "
            f"newest known here."
        )
    names = list(opened.keys())
    if len(names) > _MAX_TENSORS or not all(_NAME.fullmatch(name) for name in names):
        raise AgentFileError(f"Expected at most {_MAX_TENSORS:,} tensors with plain names.")
    return SavedBaseline(
        algorithm=Algorithm(
            manifest.one_of("algorithm", [algorithm.value for algorithm in Algorithm])
        ),
        spec=task_from_json(Fields(manifest.mapping("task"), "task")),
        settings=manifest.mapping("settings"),
        seed=manifest.whole("seed", most=2**63 - 1),
        n_steps=manifest.whole("n_steps"),
        tensors={name: _tensor(opened, name) for name in names},
    )


def _tensor(opened: Any, name: str) -> NDArray:
    kind = opened.get_slice(name).get_dtype()
    if kind not in _DTYPES:
        raise AgentFileError(f"Expected plain numbers in {quote(name)}, but it has {quote(kind)}.")
    array = opened.get_tensor(name)
    if not np.isfinite(array).all():
        raise AgentFileError(f"Expected finite numbers in {quote(name)}.")
    return array
