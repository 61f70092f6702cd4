"""`ao2viz results`: what a table of experiments says, over its seeds."""

import json
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from ao2viz.cli.console import say_aside, show_json, show_table
from ao2viz.cli.files import check_folder, check_name, write_text
from ao2viz.experiments.plan import say_settings
from ao2viz.experiments.report import number, write_into
from ao2viz.experiments.statistics import Summary, summarise
from ao2viz.experiments.table import TableError, read
from ao2viz.figures.learning_curves import Curve, learning_curves_figure


def run(file: Path, *, markdown: Path | None, plot: Path | None, as_json: bool) -> None:
    """Prints a line for each group of seeds, and writes what else was asked for.

    Raises:
        ValueError: If the file is no table of a sweep, or a page has no place for its tables.
        OSError: If a file cannot be read or written.
    """
    for path, suffix in ((markdown, ".md"), (plot, ".html")):
        if path is not None:
            check_name(path, suffix)
            check_folder(path)
    summaries = summarise(read(file))
    if not summaries:
        raise TableError(f"{file} holds no runs yet.")
    if markdown is not None:
        page = markdown.read_text("utf-8") if markdown.exists() else None
        try:
            written = write_into(page, summaries, file.name)
        except ValueError as error:
            raise ValueError(f"{markdown}: {error}") from error
        write_text(markdown, written)
        say_aside(f"The tables are in {markdown}.")
    if plot is not None:
        figure = learning_curves_figure(make_curves(summaries))
        write_text(plot, figure.to_html(include_plotlyjs=True))
        say_aside(f"The learning curves are in {plot}.")
    if as_json:
        show_json({"file": str(file), "groups": [_to_json(one) for one in summaries]})
    else:
        _show(summaries)


def make_curves(summaries: Sequence[Summary]) -> list[Curve]:
    """The learning curve of each environment, preset, settings and way of deciding."""
    groups: dict[tuple[str, str, str], list[Summary]] = defaultdict(list)
    for one in summaries:
        group = f"{one.preset.value}{say_settings(one.settings)}"
        groups[one.env, group, one.decide_by.value].append(one)
    return [_make_curve(group, along) for (_, group, _), along in groups.items()]


def _make_curve(group: str, along: Sequence[Summary]) -> Curve:
    intervals = [one.interval or (one.iqm, one.iqm) for one in along]
    seeds = sorted({each.run.seed for one in along for each in one.evaluations})
    returns = {seed: np.full(len(along), np.nan) for seed in seeds}
    for at, one in enumerate(along):
        for each in one.evaluations:
            returns[each.run.seed][at] = each.mean_return
    return Curve(
        env=along[0].env,
        group=group,
        decide_by=along[0].decide_by,
        steps=np.array([one.steps for one in along]),
        middle=np.array([one.iqm for one in along]),
        low=np.array([low for low, _ in intervals]),
        high=np.array([high for _, high in intervals]),
        seeds=returns,
    )


def _show(summaries: Sequence[Summary]) -> None:
    table = Table(box=None, pad_edge=False)
    for heading in ("Environment", "Preset", "Settings"):
        table.add_column(heading, overflow="fold")
    table.add_column("Steps", justify="right")
    table.add_column("By")
    for heading in (
        "Seeds", "Mean", "Least", "Greatest", "IQM", "95 % interval", "Options", "Stack", "CPU s",
    ):  # fmt: skip
        table.add_column(heading, justify="right")
    for one in summaries:
        table.add_row(*(Text(cell) for cell in _cells(one)))
    show_table(table)


def _cells(one: Summary) -> list[str]:
    means = one.means
    interval = "" if one.interval is None else " … ".join(number(end) for end in one.interval)
    return [
        one.env,
        one.preset.value,
        say_settings(one.settings).strip(),
        f"{one.steps:,}",
        one.decide_by.value,
        f"{len(means)}",
        *(number(value) for value in (means.mean(), means.min(), means.max(), one.iqm)),
        interval,
        f"{one.options:,.0f}",
        f"{one.stack_mean:.1f}" if one.stack_most else "",  # A network has none.
        f"{one.cpu_s:,.1f}",
    ]


def _to_json(one: Summary) -> dict[str, Any]:
    means = one.means
    return {
        "environment": one.env,
        "preset": one.preset.value,
        "settings": json.loads(one.settings),
        "steps": one.steps,
        "decide_by": one.decide_by.value,
        "seeds": [each.run.seed for each in one.evaluations],
        "means": means.tolist(),
        "mean": float(means.mean()),
        "least": float(means.min()),
        "greatest": float(means.max()),
        "iqm": one.iqm,
        "interval": one.interval,
        "episodes": len(one.evaluations[0].returns),
        "options": one.options,
        "stack_mean": one.stack_mean,
        "stack_most": one.stack_most,
        "cpu_s": one.cpu_s,
        "made_by": sorted({str(each.made_by) for each in one.evaluations}),
    }
