"""Learning curves as one small JSON file, which the dashboard lays behind a run, and as CSV."""

import json
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np

from ao2viz.exports.tables import write_rows
from ao2viz.figures.behind import Behind
from ao2viz.store.errors import AgentFileError, quote
from ao2viz.store.fields import Fields, parse_object

FORMAT = "ao2viz-learner-curves"
FORMAT_VERSION = 1

_LARGEST = 4 * 2**20  # Bytes; the paper's three tasks take 20 KB.
_MOST_CURVES = 200
_MOST_CHECKPOINTS = 10_000
_MOST_SEEDS = 1_000
_LATEST = 10**12  # Steps.
# Names are written into pages and charts.
_PLAIN = re.compile(r"[\w+./ -]{1,60}", re.ASCII)


def to_json(curves: Sequence[Behind]) -> str:
    """The curves as a file's text, one in a line; ranks become the order of `learners`."""
    head = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "learners": list(
            dict.fromkeys(one.learner for one in sorted(curves, key=lambda one: one.rank))
        ),
    }
    lines = [
        json.dumps(
            {
                "env": one.env,
                "learner": one.learner,
                "steps": one.steps.tolist(),
                "seeds": list(one.seeds),
                "returns": one.returns.round(3).tolist(),
            }
        )
        for one in curves
    ]
    return json.dumps(head)[:-1] + ', "curves": [\n' + ",\n".join(lines) + "\n]}\n"


def read_learner_curves(path: Path) -> tuple[Behind, ...]:
    """The curves of a file that `ao2viz paper` wrote.

    Raises:
        ValueError: If it holds something else; one line that says what was expected.
        OSError: If it cannot be read.
    """
    try:
        if path.stat().st_size > _LARGEST:
            raise AgentFileError(f"Expected at most {_LARGEST / 2**20:g} MiB.")
        fields = Fields(parse_object(path.read_bytes()), "file")
        fields.one_of("format", [FORMAT])
        fields.whole("format_version", FORMAT_VERSION, FORMAT_VERSION)
        learners = fields.items("learners", _MOST_CURVES)
        return tuple(_to_curve(one, learners) for one in fields.items("curves", _MOST_CURVES))
    except AgentFileError as error:
        raise ValueError(
            f"{path.name} is no curves.json as ao2viz paper writes it: {error}"
        ) from error


def write_learner_curves_csv(curves: Iterable[Behind], stream: IO[bytes]) -> None:
    """One row for each checkpoint of each seed."""
    rows = (
        (one.env, one.learner, seed, steps, earned)
        for one in curves
        for seed, returns in zip(one.seeds, one.returns.tolist(), strict=True)
        for steps, earned in zip(one.steps.tolist(), returns, strict=True)
    )
    write_rows(stream, ("environment", "learner", "seed", "steps", "mean return"), rows)


def _to_curve(found: Any, learners: list[Any]) -> Behind:
    fields = Fields(found, "curve")
    env, learner = (_plain(fields.text(name)) for name in ("env", "learner"))
    if learner not in learners:
        raise AgentFileError(f"Expected {quote(learner)} among the learners of the file.")
    steps = _rising(fields, "steps", _MOST_CHECKPOINTS, least=1)
    seeds = _rising(fields, "seeds", _MOST_SEEDS, least=0)
    returns = fields.items("returns", _MOST_SEEDS)
    rows = [row if isinstance(row, list) else [] for row in returns]
    are_numbers = all(type(one) in (int, float) and abs(one) < 1e12 for row in rows for one in row)
    if [len(row) for row in rows] != [len(steps)] * len(seeds) or not are_numbers:
        raise AgentFileError(
            f"Expected {len(seeds)} lists of {len(steps)} finite returns of {learner} on {env}."
        )
    return Behind(
        env=env,
        learner=learner,
        rank=learners.index(learner),
        steps=np.array(steps, np.int64),
        seeds=tuple(seeds),
        returns=np.array(rows, np.float64),
    )


def _plain(name: str) -> str:
    if not _PLAIN.fullmatch(name):
        raise AgentFileError(f"Expected a short plain name, but got {quote(name)}.")
    return name


def _rising(fields: Fields, name: str, most: int, *, least: int) -> list[int]:
    values = fields.items(name, most)
    sound = all(type(value) is int and least <= value < _LATEST for value in values)
    if not values or not sound or values != sorted(set(values)):
        raise AgentFileError(f"Expected rising whole numbers from {least} on as {name!r}.")
    return values
