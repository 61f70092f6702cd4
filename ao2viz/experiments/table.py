"""The table of an experiment: one Parquet file, one row for each evaluation.

Every finished run rewrites the file as a whole and puts it in the place of the old one. That is
some milliseconds against the minutes of a run, and a kill at any moment leaves a sound table.
"""

import contextlib
import dataclasses
import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from ao2viz.baselines.algorithm import Acting, Algorithm
from ao2viz.core.config import Preset
from ao2viz.core.decision import DecideBy
from ao2viz.experiments.locks import locked
from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.plan import Learner, Run, Schedule, Way
from ao2viz.experiments.provenance import Provenance
from ao2viz.store.replacing import replacing

SUFFIX = ".parquet"
FORMAT_VERSION = 2
_FORMAT = b"ao2viz_results"  # Its version, in the file's metadata.
SCHEMA = pa.schema(
    [
        pa.field("env", pa.string(), nullable=False),
        pa.field("preset", pa.string(), nullable=False),
        pa.field("settings", pa.string(), nullable=False),  # A JSON object.
        pa.field("seed", pa.int64(), nullable=False),
        pa.field("steps", pa.int64(), nullable=False),
        pa.field("decide_by", pa.string(), nullable=False),
        pa.field("mean_return", pa.float64(), nullable=False),
        pa.field("standard_error", pa.float64()),  # Missing for a single episode.
        pa.field("returns", pa.list_(pa.float64()), nullable=False),  # One an episode.
        pa.field("options", pa.int64(), nullable=False),
        pa.field("stack_mean", pa.float64(), nullable=False),
        pa.field("stack_most", pa.int64(), nullable=False),
        pa.field("cpu_s", pa.float64(), nullable=False),
        pa.field("version", pa.string(), nullable=False),
        pa.field("commit", pa.string()),  # Missing outside a checkout.
        pa.field("finished_at", pa.timestamp("us", tz="UTC"), nullable=False),
        pa.field("episode_ends", pa.list_(pa.int64())),  # Missing in tables of format 1.
        pa.field("episode_returns", pa.list_(pa.float64())),
    ],
    metadata={_FORMAT: str(FORMAT_VERSION).encode()},
)

_SINCE_2 = ("episode_ends", "episode_returns")

# All that names and settings need; what is shown on pages cannot be more than text.
_PLAIN = re.compile(r'[\w\s{}":,.+/-]*')

_Key = tuple[Run, int, Way]


class TableError(ValueError):
    """A file is no table of experiments, or one that must not be added to."""


class Table:
    """A table that is open for adding to; see `opened`."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._rows = _read_rows(path) if path.exists() else SCHEMA.empty_table()
        held = _to_evaluations(path, self._rows)
        self._episodes = {_key(evaluation): len(evaluation.returns) for evaluation in held}
        self.made_by = {evaluation.made_by for evaluation in held}
        """Every code that rows were measured with."""

    def __len__(self) -> int:
        """Rows."""
        return self._rows.num_rows

    def evaluations(self) -> list[Evaluation]:
        """Every row, in the order in which the runs finished."""
        return _to_evaluations(self.path, self._rows)

    def holds(self, run: Run, schedule: Schedule) -> bool:
        """Whether nothing of a run is left to measure.

        Raises:
            TableError: If some of it was measured with another number of episodes.
        """
        held = [
            self._episodes.get((run, steps, decide_by))
            for steps in schedule.checkpoints
            for decide_by in run.ways
        ]
        for episodes in held:
            if episodes not in (None, schedule.episodes):
                raise TableError(
                    f"{self.path} holds {run} with {episodes} episodes, not {schedule.episodes}. "
                    f"Ask for as many (--episodes), or name another table."
                )
        return None not in held

    def add(self, evaluations: Iterable[Evaluation]) -> None:
        """Adds what is not in the table yet: all of it or, on an error, nothing.

        Raises:
            OSError: If the file cannot be written; it is as it was, then.
        """
        new = [evaluation for evaluation in evaluations if _key(evaluation) not in self._episodes]
        added = pa.Table.from_pylist([_to_row(evaluation) for evaluation in new], SCHEMA)
        rows = pa.concat_tables([self._rows, added])
        _write(self.path, rows)
        self._rows = rows
        self._episodes |= {_key(evaluation): len(evaluation.returns) for evaluation in new}
        self.made_by |= {evaluation.made_by for evaluation in new}


@contextlib.contextmanager
def opened(path: Path) -> Iterator[Table]:
    """A table to add to, made with its first rows if there is none; nobody else may add to it.

    Raises:
        TableError: If the file is no such table, or was written by a newer ao2viz.
        ValueError: If another sweep adds to it.
        OSError: If it cannot be read.
    """
    with locked(path):
        yield Table(path)


def read(path: Path) -> list[Evaluation]:
    """Every row of a table, in the order in which the runs finished.

    Raises:
        TableError: If the file is no such table, or was written by a newer ao2viz.
        OSError: If it cannot be read.
    """
    return _to_evaluations(path, _read_rows(path))


def _read_rows(path: Path) -> pa.Table:
    content = path.read_bytes()
    try:
        is_old = _check_schema(path, pq.read_schema(pa.BufferReader(content)))
        rows = pq.read_table(pa.BufferReader(content))
        for name in _SINCE_2 if is_old else ():
            field = SCHEMA.field(name)
            rows = rows.append_column(field, pa.nulls(len(rows), field.type))
    except (pa.ArrowException, OSError) as error:  # OSError: what is written in it misleads.
        raise TableError(f"{path} is no sound Parquet file: {error}") from error
    return rows.replace_schema_metadata(SCHEMA.metadata)


def _to_evaluations(path: Path, rows: pa.Table) -> list[Evaluation]:
    try:
        evaluations = [_from_row(row) for row in rows.to_pylist()]
    except (ValueError, TypeError) as error:
        raise TableError(f"{path} holds what no sweep has written: {error}") from error
    if len({_key(evaluation) for evaluation in evaluations}) < len(evaluations):
        raise TableError(f"{path} holds a run twice; its statistics would be wrong.")
    return evaluations


def _check_schema(path: Path, found: pa.Schema) -> bool:
    """Whether a sound table is of format 1, which knew nothing of training episodes."""
    version = (found.metadata or {}).get(_FORMAT, b"")
    if version.isdigit() and int(version) > FORMAT_VERSION:
        raise TableError(
            f"{path} was written by a newer ao2viz: its format is {int(version)}, and "
            f"{FORMAT_VERSION} is the newest known here."
        )
    is_old = version == b"1"
    known = [f for f in SCHEMA if not (is_old and f.name in _SINCE_2)]
    told = []
    for words, names in (
        ("lacks", [f.name for f in known if f.name not in found.names]),
        ("also has", [name for name in found.names if name not in {f.name for f in known}]),
        (
            "has another type in",
            [
                f.name
                for f in known
                if f.name in found.names and not found.field(f.name).type.equals(f.type)
            ],
        ),
    ):
        if names:
            told.append(f"{words} {', '.join(names)}")
    if told:
        raise TableError(f"{path} is no table of a sweep: it {'; it '.join(told)}.")
    return is_old


def _write(path: Path, rows: pa.Table) -> None:
    sink = pa.BufferOutputStream()
    pq.write_table(rows.combine_chunks(), sink, compression="zstd")
    with replacing(path) as stream:
        stream.write(sink.getvalue())


def _key(evaluation: Evaluation) -> _Key:
    return evaluation.run, evaluation.steps, evaluation.decide_by


def _to_row(evaluation: Evaluation) -> dict[str, Any]:
    run = evaluation.run
    return {
        "env": run.env,
        "preset": run.preset.value,
        "settings": run.settings,
        "seed": run.seed,
        "steps": evaluation.steps,
        "decide_by": evaluation.decide_by.value,
        "mean_return": evaluation.mean_return,
        "standard_error": evaluation.standard_error,
        "returns": list(evaluation.returns),
        "options": evaluation.options,
        "stack_mean": evaluation.stack_mean,
        "stack_most": evaluation.stack_most,
        "cpu_s": evaluation.cpu_s,
        **evaluation.made_by._asdict(),
        "finished_at": evaluation.finished_at,
        "episode_ends": list(evaluation.episode_ends),
        "episode_returns": list(evaluation.episode_returns),
    }


def _from_row(row: dict[str, Any]) -> Evaluation:
    missing = [f.name for f in SCHEMA if not f.nullable and row[f.name] is None]
    if missing:
        raise ValueError(f"expected a value in {', '.join(missing)}.")
    for name, value in row.items():
        if isinstance(value, str) and not _PLAIN.fullmatch(value):
            raise ValueError(f"expected plain text in {name}, but got {value!r}.")
    if not isinstance(json.loads(row["settings"]), dict):
        raise ValueError(f"expected a JSON object as settings, but got {row['settings']!r}.")
    if not row["returns"] or None in row["returns"]:
        raise ValueError("expected the return of at least one episode, and none missing.")
    ends, earned = (tuple(row[name] or ()) for name in _SINCE_2)
    if len(ends) != len(earned) or None in ends or None in earned:
        raise ValueError("expected the end and the return of every training episode.")
    preset = to_learner(row["preset"])
    way = DecideBy if isinstance(preset, Preset) else Acting
    return Evaluation(
        run=Run(row["env"], preset, row["settings"], row["seed"]),
        decide_by=way(row["decide_by"]),
        returns=tuple(row["returns"]),
        episode_ends=ends,
        episode_returns=earned,
        made_by=Provenance(row["version"], row["commit"]),
        **{
            field.name: row[field.name]
            for field in dataclasses.fields(Evaluation)
            if field.name not in {"run", "decide_by", "returns", "made_by", *_SINCE_2}
        },
    )


def to_learner(name: str) -> Learner:
    """The preset or the algorithm of that name.

    Raises:
        ValueError: If there is none.
    """
    known = {one.value: one for one in (*Preset, *Algorithm)}
    if name not in known:
        raise ValueError(f"{name!r} is not a valid Preset, and no Algorithm.")
    return known[name]
