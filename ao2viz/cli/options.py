"""Arguments and options that several commands have."""

from pathlib import Path
from typing import Annotated

import typer

AgentFile = Annotated[Path, typer.Argument(metavar="FILE", help="An agent's .ao2 file.")]
Env = Annotated[
    str | None,
    typer.Option(
        "--env",
        metavar="ENV",
        help="The environment, where the id in the file is not enough: module:EnvId.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON value instead of text.")]
StepOf = Annotated[
    int | None, typer.Option(min=0, help="Its step, counted from 0; otherwise the first.")
]
Workers = Annotated[
    int | None, typer.Option(min=1, help="Runs at a time; otherwise one for each processor.")
]
