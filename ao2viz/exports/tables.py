"""Decisions as tables: CSV and Parquet, one row a step or one row an option of a path."""

import csv
import io
import itertools
import json
from collections.abc import Iterable, Iterator, Sequence
from typing import IO, Any

from ao2viz.explain.plain import to_plain
from ao2viz.exports.content import (
    Content,
    Step,
    number_or_none,
    option_or_none,
    path_elements,
)
from ao2viz.exports.escaping import to_cell


def write_steps_csv(content: Content, stream: IO[bytes]) -> None:
    """One row a step; the path as ids from the root on."""
    content.need_episodes()
    spec = content.spec
    head = [
        *("episode", "step"),
        *(f"observation {i}: {f.name}" for i, f in enumerate(spec.features)),
        *("action", "action name"),
        *(f"expected {i}: {name}" for i, name in enumerate(spec.action_names)),
        *("margin", "reward", "path", "distance", "runner-up option", "runner-up distance"),
        *("voters", "explored", "tie", "new option", "reason", "faithful"),
    ]
    rows = (
        [
            *(episode, step.number),
            *step.decision.observation.tolist(),
            *(step.decision.action, step.said.headline),
            *step.decision.action_values.tolist(),
            step.decision.margin,
            step.reward,
            " > ".join(str(option) for option in step.decision.path.tolist()),
            number_or_none(step.decision.distance),
            option_or_none(step.decision.runner_up_option),
            number_or_none(step.decision.runner_up_distance),
            len(step.decision.voters),
            int(step.decision.explored),
            int(step.decision.is_tie),
            option_or_none(step.decision.created),
            step.said.reason,
            int(step.is_faithful),
        ]
        for episode, step in content.all_steps()
    )
    write_rows(stream, head, rows)


def write_paths_csv(content: Content, stream: IO[bytes]) -> None:
    """One row for each option on each path of each step, the path of the most similar first."""
    content.need_episodes()
    head = [
        *("episode", "step", "voter", "share", "position", "option", "distance"),
        "action name",
        "faithful",
    ]
    write_rows(stream, head, _path_rows(content))


def write_parquet(content: Content, stream: IO[bytes]) -> None:
    """One row a step, with lists where there are several numbers; names are in the metadata."""
    import pyarrow as pa  # noqa: PLC0415 -- an extra.
    import pyarrow.parquet as pq  # noqa: PLC0415

    content.need_episodes()
    numbers = pa.list_(pa.float64())
    element = pa.struct([("option", pa.int64()), ("distance", pa.float64())])
    voter = pa.struct(
        [("option", pa.int64()), ("share", pa.float64()), ("path", pa.list_(element))]
    )
    schema = pa.schema(
        [
            pa.field("episode", pa.int64(), nullable=False),
            pa.field("step", pa.int64(), nullable=False),
            pa.field("observation", numbers, nullable=False),
            pa.field("action", pa.int64(), nullable=False),
            pa.field("action_name", pa.string(), nullable=False),
            pa.field("reward", pa.float64(), nullable=False),
            pa.field("action_values", numbers, nullable=False),
            pa.field("margin", pa.float64(), nullable=False),
            pa.field("path", pa.list_(element), nullable=False),
            pa.field("voters", pa.list_(voter), nullable=False),
            pa.field("runner_up_option", pa.int64()),
            pa.field("runner_up_distance", pa.float64()),
            pa.field("explored", pa.bool_(), nullable=False),
            pa.field("is_tie", pa.bool_(), nullable=False),
            pa.field("created_option", pa.int64()),
            pa.field("reason", pa.string(), nullable=False),
            pa.field("is_faithful", pa.bool_(), nullable=False),
        ],
        metadata={
            "ao2viz": json.dumps(
                {
                    "environment": content.spec.env_id,
                    "features": [f.name for f in content.spec.features],
                    "actions": list(content.spec.action_names),
                    "faithfulness": to_plain(content.faithfulness),
                }
            )
        },
    )
    rows = [_to_row(episode, step) for episode, step in content.all_steps()]
    pq.write_table(pa.Table.from_pylist(rows, schema), stream, compression="zstd")


def _to_row(episode: int, step: Step) -> dict[str, Any]:
    decision = step.decision
    voters = [
        {"option": option, "share": share, "path": path_elements(step.decision, k)}
        for k, (option, share) in enumerate(
            zip(decision.voters.tolist(), decision.shares.tolist(), strict=True)
        )
    ]
    return {
        "episode": episode,
        "step": step.number,
        "observation": decision.observation.tolist(),
        "action": decision.action,
        "action_name": step.said.headline,
        "reward": step.reward,
        "action_values": decision.action_values.tolist(),
        "margin": decision.margin,
        "path": voters[0]["path"] if voters else [],
        "voters": voters,
        "runner_up_option": option_or_none(decision.runner_up_option),
        "runner_up_distance": number_or_none(decision.runner_up_distance),
        "explored": decision.explored,
        "is_tie": decision.is_tie,
        "created_option": option_or_none(decision.created),
        "reason": step.said.reason,
        "is_faithful": step.is_faithful,
    }


def _path_rows(content: Content) -> Iterator[list[Any]]:
    for episode, step in content.all_steps():
        for k, share in enumerate(step.decision.shares.tolist()):
            for position, element in enumerate(path_elements(step.decision, k)):
                yield [
                    *(episode, step.number, k, share, position),
                    *(element["option"], element["distance"], step.said.headline),
                    int(step.is_faithful),
                ]


def write_rows(stream: IO[bytes], head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Writes UTF-8 with the mark that table programs need to see that it is."""
    text = io.TextIOWrapper(stream, "utf-8-sig", newline="", write_through=True)
    writer = csv.writer(text)
    for row in itertools.chain([head], rows):
        writer.writerow([to_cell(cell) if isinstance(cell, str) else cell for cell in row])
    text.detach()  # The stream is the caller's to close.
