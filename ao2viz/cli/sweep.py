"""`ao2viz sweep`: many runs in parallel into one table, to be gone on with at any time."""

import contextlib
import json
import re
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

from ao2viz.cli.console import say, say_aside, say_error, show_json, stderr
from ao2viz.cli.exit_codes import EXIT_FAILED
from ao2viz.cli.files import check_folder, check_name
from ao2viz.cli.interrupts import DeferredInterrupts
from ao2viz.core.config import Preset
from ao2viz.experiments.clusters import Cluster, Workers, WorkersLostError, gather
from ao2viz.experiments.measure import Outcome
from ao2viz.experiments.plan import MAX_RUNS, Run, Schedule, make_runs, make_schedule
from ao2viz.experiments.provenance import provenance
from ao2viz.experiments.sweep import missing, sweep
from ao2viz.experiments.table import SUFFIX, Table, opened

_NAMED = 2
"""Runs under way that the progress line names; the others it counts."""


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
        left = missing(table, runs, schedule)
        others = sorted({str(other) for other in table.made_by} - {str(provenance())})
        if left and others:
            say_aside(f"{out} also holds runs of {', '.join(others)}; this is {provenance()}.")
        progress = _Sweep(table, runs, left)
        started = time.perf_counter()
        code = progress.run(schedule, cluster, workers, address) if left else 0
        summary = progress.summarise(time.perf_counter() - started)
    if as_json:
        show_json(summary)
    else:
        say(f"{summary['done']:,} of {summary['runs']:,} runs are in {out}.")
        if summary["done"]:
            say(f"To see them: ao2viz results {out}")
    return code


class _Sweep:
    """The runs of one command: which are done, under way, or failed."""

    def __init__(self, table: Table, runs: Sequence[Run], left: Sequence[Run]) -> None:
        self._table = table
        self._runs = runs
        self._left = left
        self._done = 0
        self._failed: list[Outcome] = []

    def run(
        self, schedule: Schedule, cluster: Cluster, workers: int | None, address: str | None
    ) -> int:
        """Does what is left, and says how it went; returns the exit code.

        Raises:
            ValueError: If there is no such cluster, or it has another version of ao2viz.
            OSError: If there is no cluster at the address.
        """
        total = len(self._runs)
        before = total - len(self._left)
        if before:
            say_aside(f"{before:,} of {total:,} runs are in {self._table.path} already.")
        trouble = ""
        # Whoever asks to stop need not wait for a run: those under way are lost, no others.
        with DeferredInterrupts(_stop) as interrupts:
            try:
                with gather(cluster, workers, address) as hands, _Display(before, total) as display:
                    trouble = self._work(schedule, hands, display)
            except KeyboardInterrupt:
                self._say_left("Stopped.")
                return interrupts.exit_code
        if trouble:
            say_error(trouble)
            self._say_left("The runs under way were dropped.")
        elif self._failed:
            self._say_left(f"{_count(len(self._failed))} failed.")
        return EXIT_FAILED if trouble or self._failed else 0

    def summarise(self, seconds: float) -> dict[str, Any]:
        """What came of it, in JSON values."""
        before = len(self._runs) - len(self._left)
        return {
            "file": str(self._table.path),
            "runs": len(self._runs),
            "done": before + self._done,
            "done_before": before,
            "failed": [
                {"run": str(outcome.run), "error": outcome.error} for outcome in self._failed
            ],
            "seconds": round(seconds, 3),
        }

    def _work(self, schedule: Schedule, hands: Workers, display: "_Display") -> str:
        """What kept it from doing everything; empty if nothing did."""
        outcomes = sweep(self._table, self._left, schedule, hands, display.show_start)
        try:
            with contextlib.closing(outcomes):
                for outcome in outcomes:
                    if outcome.error:
                        self._failed.append(outcome)
                    else:
                        self._done += 1
                    display.show_end(outcome)
        except WorkersLostError as error:
            return f"The workers were lost. {error}"
        except OSError as error:
            return f"Could not write {self._table.path}: {error.strerror or error}."
        return ""

    def _say_left(self, why: str) -> None:
        left = len(self._left) - self._done
        say_aside(f"{why} {_count(left)} left to do; the same command goes on with them.")


class _Display:
    """The progress line, and a line for every run that ends; only those where nobody watches."""

    def __init__(self, done: int, total: int) -> None:
        self._console = stderr()
        self._under_way: dict[Run, None] = {}
        self._ended, self._total = done, total
        self._progress = Progress(
            TextColumn("[bold]Runs"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            TextColumn("{task.fields[note]}", markup=False),
            console=self._console,
            disable=not self._console.is_terminal,
        )
        self._task = self._progress.add_task("", total=total, completed=done, note="")
        self._done_before = done
        self._started = time.perf_counter()

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def show_start(self, run: Run) -> None:
        """A worker has begun with a run. May be called from any thread."""
        self._under_way[run] = None
        self._note()

    def show_end(self, outcome: Outcome) -> None:
        """A run is in the table, or has failed."""
        self._under_way.pop(outcome.run, None)
        self._ended += 1
        self._progress.update(self._task, completed=self._ended)
        self._note()
        line = f"{self._ended:,}/{self._total:,}  {outcome.run}: {_say_outcome(outcome)}"
        if not self._console.is_terminal and self._ended < self._total:
            spent = time.perf_counter() - self._started
            left = spent / (self._ended - self._done_before) * (self._total - self._ended)
            line += f"  ({_say_duration(left)} to go)"
        style = "red" if outcome.error else ""
        self._progress.console.print(Text(line, style=style), soft_wrap=True)

    def _note(self) -> None:
        names = [str(run) for run in list(self._under_way)]
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        self._progress.update(self._task, note=", ".join(names[:_NAMED]) + more)


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


def _stop() -> None:
    raise KeyboardInterrupt


def _count(runs: int) -> str:
    return f"{runs:,} run{'' if runs == 1 else 's'}"


def _say_outcome(outcome: Outcome) -> str:
    if outcome.error:
        return f"failed: {outcome.error}"
    last = outcome.evaluations[-1]
    returns = ", ".join(
        f"{one.mean_return:.1f} by {one.decide_by.value}"
        for one in outcome.evaluations
        if one.steps == last.steps
    )
    return f"{returns}, {last.options:,} options, {last.cpu_s:.1f} CPU s"


def _say_duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}"
