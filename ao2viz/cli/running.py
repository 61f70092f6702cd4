"""Runs under way in the terminal: what is done, what is left, how long it will take."""

import contextlib
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

from ao2viz.cli.console import say_aside, say_error, stderr
from ao2viz.cli.exit_codes import EXIT_FAILED
from ao2viz.cli.interrupts import DeferredInterrupts
from ao2viz.core.config import Preset
from ao2viz.experiments.clusters import Cluster, Workers, WorkersLostError, gather
from ao2viz.experiments.measure import Outcome
from ao2viz.experiments.plan import Run, Task
from ao2viz.experiments.provenance import provenance
from ao2viz.experiments.sweep import missing, sweep
from ao2viz.experiments.table import Table
from ao2viz.figures.learning_curves import say_way

_NAMED = 2
"""Runs under way that the progress line names; the others it counts."""


class Sweep:
    """The runs of one command: which are done, under way, or failed."""

    def __init__(
        self,
        table: Table,
        tasks: Sequence[Task],
        seconds: Callable[[Task], float] = lambda task: 1.0,
    ) -> None:
        """Looks for what the table lacks; nothing is run yet.

        Args:
            table: Gets what is measured.
            tasks: What is to be in it.
            seconds: What a run takes, beside others; only to say how long it all will.

        Raises:
            TableError: If the table was made in another way; see `missing`.
        """
        self.left = missing(table, tasks)
        """What the table lacked."""
        self._table = table
        self._total = len(tasks)
        self._seconds = seconds
        self._failed: list[Outcome] = []
        self._started = time.perf_counter()

    def run(self, cluster: Cluster, workers: int | None, address: str | None) -> int:
        """Does what is left, and says how it went; returns the exit code.

        Raises:
            ValueError: If there is no such cluster, or it has another version of ao2viz.
            OSError: If there is no cluster at the address.
        """
        if not self.left:
            return 0
        others = sorted({str(other) for other in self._table.made_by} - {str(provenance())})
        if others:
            say_aside(
                f"{self._table.path} also holds runs of {', '.join(others)}; this is "
                f"{provenance()}."
            )
        total = self._total
        before = total - len(self.left)
        if before:
            say_aside(f"{before:,} of {total:,} runs are in {self._table.path} already.")
        trouble = ""
        # Whoever asks to stop need not wait for a run: those under way are lost, no others.
        with DeferredInterrupts(_stop) as interrupts:
            try:
                costs = {task.run: self._seconds(task) for task in self.left}
                with gather(cluster, workers, address) as hands, _Display(before, costs) as display:
                    trouble = self._work(hands, display)
            except KeyboardInterrupt:
                self._say_left("Stopped.")
                return interrupts.exit_code
        if trouble:
            say_error(trouble)
            self._say_left("The runs under way were dropped.")
        elif self._failed:
            self._say_left(f"{_count(len(self._failed))} failed.")
        return EXIT_FAILED if trouble or self._failed else 0

    @property
    def _done(self) -> int:
        """How many are in the table by now: an interrupt may come between that and being told."""
        return sum(self._table.holds(task.run, task.schedule) for task in self.left)

    def summarise(self) -> dict[str, Any]:
        """What came of it, in JSON values."""
        before = self._total - len(self.left)
        return {
            "file": str(self._table.path),
            "runs": self._total,
            "done": before + self._done,
            "done_before": before,
            "failed": [
                {"run": str(outcome.run), "error": outcome.error} for outcome in self._failed
            ],
            "seconds": round(time.perf_counter() - self._started, 3),
        }

    def _work(self, hands: Workers, display: "_Display") -> str:
        """What kept it from doing everything; empty if nothing did."""
        outcomes = sweep(self._table, self.left, hands, display.show_start)
        try:
            with contextlib.closing(outcomes):
                for outcome in outcomes:
                    if outcome.error:
                        self._failed.append(outcome)
                    display.show_end(outcome)
        except WorkersLostError as error:
            return f"The workers were lost. {error}"
        except OSError as error:
            return f"Could not write {self._table.path}: {error.strerror or error}."
        return ""

    def _say_left(self, why: str) -> None:
        left = len(self.left) - self._done
        say_aside(f"{why} {_count(left)} left to do; the same command goes on with them.")


class _Display:
    """The progress line, and a line for every run that ends; only those where nobody watches."""

    def __init__(self, done: int, costs: Mapping[Run, float]) -> None:
        self._console = stderr()
        self._under_way: dict[Run, None] = {}
        self._ended, self._total = done, done + len(costs)
        self._costs, self._spent = costs, 0.0
        self._progress = Progress(
            TextColumn("[bold]Runs"),
            BarColumn(),
            TextColumn("{task.fields[count]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[note]}", markup=False),
            console=self._console,
            disable=not self._console.is_terminal,
        )
        # The bar goes by what runs take; what was done before is not its business.
        self._task = self._progress.add_task(
            "", total=sum(costs.values()), note="", count=f"{done}/{self._total}"
        )
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
        self._spent += self._costs[outcome.run]
        count = f"{self._ended}/{self._total}"
        self._progress.update(self._task, completed=self._spent, count=count)
        self._note()
        line = f"{self._ended:,}/{self._total:,}  {outcome.run}: {_say_outcome(outcome)}"
        if not self._console.is_terminal and self._ended < self._total:
            spent = time.perf_counter() - self._started
            left = spent / self._spent * (sum(self._costs.values()) - self._spent)
            line += f"  ({_say_duration(left)} to go)"
        style = "red" if outcome.error else ""
        self._progress.console.print(Text(line, style=style), soft_wrap=True)

    def _note(self) -> None:
        names = [str(run) for run in list(self._under_way)]
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        self._progress.update(self._task, note=", ".join(names[:_NAMED]) + more)


def _stop() -> None:
    raise KeyboardInterrupt


def _count(runs: int) -> str:
    return f"{runs:,} run{'' if runs == 1 else 's'}"


def _say_outcome(outcome: Outcome) -> str:
    if outcome.error:
        return f"failed: {outcome.error}"
    last = outcome.evaluations[-1]
    returns = ", ".join(
        f"{one.mean_return:.1f} {say_way(one.decide_by)}"
        for one in outcome.evaluations
        if one.steps == last.steps
    )
    size = "options" if isinstance(last.run.preset, Preset) else "parameters"
    return f"{returns}, {last.options:,} {size}, {last.cpu_s:.1f} CPU s"


def _say_duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}"
