"""`ao2viz paper`: the paper's experiments beside its rivals, and the report of what came out."""

from collections.abc import Sequence
from pathlib import Path

from ao2viz.baselines.algorithm import Algorithm
from ao2viz.cli.console import say, show_json
from ao2viz.cli.files import check_folder, write_text
from ao2viz.cli.running import Sweep
from ao2viz.experiments.clusters import Cluster
from ao2viz.experiments.table import opened
from ao2viz.exports.learner_curves import to_json
from ao2viz.extras import need
from ao2viz.paper.document import pictures_of, to_markdown, to_page
from ao2viz.paper.findings import TITLE, report
from ao2viz.paper.learners import learner_curves
from ao2viz.paper.plan import FULL, QUICK, make_tasks, only, seconds

TABLE = "results.parquet"
CURVES = "curves.json"


def run(
    *,
    out: Path,
    quick: bool,
    seeds: int | None,
    rival_seeds: int | None,
    names: Sequence[str],
    report_only: bool,
    workers: int | None,
    as_json: bool,
) -> int:
    """Does what the table lacks, and writes the report; returns the exit code.

    Raises:
        ValueError: If a name is unknown, or the table was made otherwise; nothing has been run.
        OSError: If a file cannot be read or written to.
    """
    extent = QUICK if quick else FULL
    n_seeds = extent.seeds if seeds is None else seeds
    n_rivals = min(n_seeds, extent.rival_seeds) if rival_seeds is None else rival_seeds
    tasks = make_tasks(extent, n_seeds, n_rivals)
    chosen = only(tasks, names)
    check_folder(out / TABLE)
    with opened(out / TABLE) as table:
        progress = Sweep(table, [] if report_only else chosen, seconds)
        if any(isinstance(task.run.preset, Algorithm) for task in progress.left):
            need("baselines")  # Now, and not after hours with AO2.
        code = progress.run(Cluster.LOCAL, workers, None)
        summary = progress.summarise()
        evaluations = table.evaluations()
    command = "ao2viz paper" + (" --quick" if quick else "")
    command += f" --seeds {n_seeds} --rival-seeds {n_rivals} --out {out.as_posix()}"
    sections = report(evaluations, tasks, command)
    write_text(out / "report.md", to_markdown(TITLE, sections))
    write_text(out / "report.html", to_page(TITLE, sections))
    write_text(out / CURVES, to_json(learner_curves(evaluations, tasks)))
    for name, svg in pictures_of(sections).items():
        write_text(out / name, svg)
    if as_json:
        show_json(summary | {"report": str(out / "report.html")})
    else:
        say(f"The report is in {out / 'report.html'}, and as Markdown in {out / 'report.md'}.")
    return code
