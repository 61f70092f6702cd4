"""The commands that run experiments and sum them up; added to the others in `commands`."""

from pathlib import Path
from typing import Annotated

import typer

from ao2viz.cli.options import Json, Workers
from ao2viz.core.config import Preset
from ao2viz.experiments.clusters import Cluster
from ao2viz.extras import need


def sweep(
    envs: Annotated[
        list[str], typer.Argument(metavar="ENV…", help="Gymnasium environments to train on.")
    ],
    steps: Annotated[int, typer.Option(min=1, help="Steps that each run learns from.")] = 20_000,
    seeds: Annotated[
        str, typer.Option(metavar="SEEDS", help="0:10 (that is 0 to 9), 0,3,7 or both: 0:3,7.")
    ] = "0:5",
    checkpoints: Annotated[
        str,
        typer.Option(
            metavar="STEPS,…", help="Evaluate after so many steps too; always after --steps."
        ),
    ] = "",
    episodes: Annotated[
        int, typer.Option(min=1, help="Greedy episodes at each checkpoint, by vote and by path.")
    ] = 100,
    preset: Annotated[
        Preset, typer.Option(help="The agent: ours, or the closest reading of the paper.")
    ] = Preset.ANTICIPATING,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE,…",
            help="Try each of these values, such as levels=3,4; repeated: every combination.",
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option(help="The table; runs that are in it already are not done again.")
    ] = Path("runs/results.parquet"),
    workers: Workers = None,
    cluster: Annotated[
        Cluster, typer.Option(help="Who does the work: this machine's processes, Dask or Ray.")
    ] = Cluster.LOCAL,
    address: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="A running cluster; otherwise one is started here."),
    ] = None,
    as_json: Json = False,
) -> int:
    """Train and evaluate over environments, settings and seeds; the same command goes on later."""
    need("experiments")
    from ao2viz.cli.sweep import run  # noqa: PLC0415 -- heavy.

    return run(
        envs,
        steps=steps,
        seeds=seeds,
        checkpoints=checkpoints,
        episodes=episodes,
        preset=preset,
        settings=settings or [],
        out=out,
        workers=workers,
        cluster=cluster,
        address=address,
        as_json=as_json,
    )


def results(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A table that sweep has made.")],
    markdown: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the tables between the marks of a .md file."),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw the learning curves into an .html file."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Sum up a sweep over its seeds: means, interquartile means with intervals, learning curves."""
    need("experiments")
    from ao2viz.cli.results import run  # noqa: PLC0415 -- heavy.

    run(file, markdown=markdown, plot=plot, as_json=as_json)


def paper(
    quick: Annotated[
        bool, typer.Option("--quick", help="A fifth of the steps, fewer seeds and episodes.")
    ] = False,
    seeds: Annotated[
        int | None, typer.Option(min=1, max=1000, help="Of AO2; otherwise 5, with --quick 2.")
    ] = None,
    rival_seeds: Annotated[
        int | None,
        typer.Option(min=0, max=1000, help="Of the others; otherwise up to 3, with --quick 1."),
    ] = None,
    names: Annotated[
        list[str] | None,
        typer.Option(
            "--only",
            metavar="NAME",
            help="Run only this learner (paper, ppo, dac+ppo …) or task; may be repeated.",
        ),
    ] = None,
    report_only: Annotated[
        bool, typer.Option("--report-only", help="Run nothing; write the report of what is there.")
    ] = False,
    out: Annotated[
        Path, typer.Option(help="Folder of the table and the report; runs in it are not repeated.")
    ] = Path("runs/paper"),
    workers: Workers = None,
    as_json: Json = False,
) -> int:
    """Run the paper's experiments, AO2 beside PPO, PPOC and DAC, and write the report."""
    need("experiments")
    from ao2viz.cli.paper import run  # noqa: PLC0415 -- heavy.

    return run(
        out=out,
        quick=quick,
        seeds=seeds,
        rival_seeds=rival_seeds,
        names=names or [],
        report_only=report_only,
        workers=workers,
        as_json=as_json,
    )
