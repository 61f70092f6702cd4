"""Many runs in parallel, each kept as soon as it is finished."""

import contextlib
from collections.abc import Callable, Generator, Iterator, Sequence

from ao2viz.experiments.clusters import Workers
from ao2viz.experiments.measure import Outcome, attempt
from ao2viz.experiments.plan import Run, Task
from ao2viz.experiments.provenance import Provenance, provenance
from ao2viz.experiments.table import Table, TableError


def missing(table: Table, tasks: Sequence[Task]) -> list[Task]:
    """The tasks that a table lacks, or has not all checkpoints of.

    Raises:
        TableError: If the table was made by another version of ao2viz, or with another number of
            episodes: figures that do not compare belong in tables of their own.
    """
    here = provenance()
    for there in table.made_by if tasks else ():  # Who adds nothing may read any table.
        _check_version(f"{table.path} was made by", there, here)
    return [task for task in tasks if not table.holds(task.run, task.schedule)]


def sweep(
    table: Table,
    tasks: Sequence[Task],
    workers: Workers,
    on_start: Callable[[Run], None] = lambda run: None,
) -> Generator[Outcome, None, None]:
    """Does the runs; each outcome is in the table by the time it is given.

    A run that fails is given with its error, and the others go on.

    Args:
        table: Gets the evaluations.
        tasks: What to do.
        workers: Who does it.
        on_start: Called with each run when a worker gets it, from any thread.

    Raises:
        OSError: If the table cannot be written.
        TableError: If the workers have another version of ao2viz.
        WorkersLostError: If a worker dies.
    """

    def given_out() -> Iterator[Task]:
        for task in tasks:
            on_start(task.run)
            yield task

    here = provenance()
    # Closed at once when we are: else the workers would go on until nobody remembers them.
    with contextlib.closing(workers.map(_attempt, given_out())) as outcomes:
        for outcome in outcomes:
            for evaluation in outcome.evaluations:
                _check_version("The workers have", evaluation.made_by, here)
            if outcome.evaluations:
                table.add(outcome.evaluations)
            yield outcome


def _attempt(task: Task) -> Outcome:
    return attempt(task.run, task.schedule)


def _check_version(whose: str, there: Provenance, here: Provenance) -> None:
    if there.version != here.version:
        raise TableError(
            f"{whose} ao2viz {there.version}, but this is {here.version}: their figures do not "
            f"compare. Use the same version, or name another table (--out)."
        )
