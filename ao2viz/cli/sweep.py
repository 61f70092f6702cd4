"""`ao2viz sweep`: many runs in parallel into one table, to be gone on with at any time."""

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ao2viz.cli.console import say, show_json
from ao2viz.cli.files import check_folder, check_name
from ao2viz.cli.running import Sweep
from ao2viz.core.config import Preset
from ao2viz.experiments.clusters import Cluster
from ao2viz.experiments.plan import MAX_RUNS, Task, make_runs, make_schedule
from ao2viz.experiments.table import SUFFIX, opened


def run(
    envs: Sequence[str],
    *,
    steps: int,
    seeds: str,
    checkpoints: str,
    episodes: int,
    preset: Preset,
    settings: Sequence[str],
    out: Path,
    workers: int | None,
    cluster: Cluster,
    address: str | None,
    as_json: bool,
) -> int:
    """Does what the table lacks and sums up; returns the exit code.

    Raises:
        ValueError: If anything asked for cannot be; nothing has been run then.
        OSError: If the table cannot be read or written to, or there is no cluster.
    """
    schedule = make_schedule(steps, parse_checkpoints(checkpoints), episodes)
    numbers = parse_seeds(seeds)
    check_name(out, SUFFIX)
    runs = make_runs(envs, preset, parse_grid(settings), numbers)
    check_folder(out)
    with opened(out) as table:
        progress = Sweep(table, [Task(one, schedule) for one in runs])
        code = progress.run(cluster, workers, address)
        summary = progress.summarise()
    if as_json:
        show_json(summary)
    else:
        say(f"{summary['done']:,} of {summary['runs']:,} runs are in {out}.")
        if summary["done"]:
            say(f"To see them: ao2viz results {out}")
    return code


def parse_seeds(text: str) -> list[int]:
    """Reads seeds: single ones and first:past-the-last, with commas between them.

    Raises:
        ValueError: If it is anything else, or no seed at all.
    """
    seeds: dict[int, None] = {}
    for part in text.split(","):
        found = re.fullmatch(r"\s*(\d{1,18})(?::(\d{1,18}))?\s*", part)
        first, past = (int(found[1]), int(found[2] or int(found[1]) + 1)) if found else (0, 0)
        if not first < past <= first + MAX_RUNS:
            raise ValueError(
                f"Expected --seeds such as 0:10 (that is 0 to 9) or 0,3,7, but got {text!r}."
            )
        seeds |= dict.fromkeys(range(first, past))
    return list(seeds)


def parse_checkpoints(text: str) -> list[int]:
    """Reads steps with commas between them; none if the text is empty.

    Raises:
        ValueError: If one is no whole number.
    """
    if not text.strip():
        return []
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(f"Expected --checkpoints such as 5000,10000, but got {text!r}.") from None


def parse_grid(settings: Sequence[str]) -> dict[str, list[Any]]:
    """Reads `NAME=VALUE,VALUE…`; values are JSON where they can be, else plain words.

    Raises:
        ValueError: If one is nothing of the kind, comes twice, or belongs to an option of its own.
    """
    grid: dict[str, list[Any]] = {}
    for setting in settings:
        name, _, text = setting.partition("=")
        values = text.split(",")
        if not name or "" in values:
            raise ValueError(
                f"Expected --set NAME=VALUE or NAME=VALUE,VALUE, such as levels=3,4, but got "
                f"{setting!r}."
            )
        if name in ("env", "preset", "seed"):
            raise ValueError(
                f"{name!r} is no setting of the preset; give it as ENV, --preset or --seeds."
            )
        if name in grid:
            raise ValueError(f"{name!r} was set twice; write --set {name}=VALUE,VALUE.")
        grid[name] = [_parse_value(value) for value in values]
    return grid


def _parse_value(text: str) -> Any:
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text
