"""Where the commands write: results to stdout, everything else to stderr."""

import json
import sys
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text


def stdout() -> Console:
    """For results. Made on each call: tests and pipes exchange `sys.stdout`."""
    return Console(file=sys.stdout, highlight=False)


def stderr() -> Console:
    """For progress, hints and errors."""
    return Console(file=sys.stderr, highlight=False)


def say(text: str) -> None:
    """Prints a line of the result as it is: names from files are never read as markup."""
    stdout().print(Text(text), soft_wrap=True)


def say_aside(text: str) -> None:
    """Prints a line that is not part of the result."""
    stderr().print(Text(text), soft_wrap=True)


def say_error(text: str) -> None:
    """Prints one line, whatever line breaks and control characters the message came with."""
    line = " ".join(text.split())
    shown = "".join(c if c.isprintable() else "�" for c in line)
    stderr().print(Text.assemble(("Error: ", "bold red"), shown), soft_wrap=True)


def show_json(value: Any) -> None:
    """Prints one JSON value; what JSON cannot say (NaN, infinity) is refused."""
    print(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


def show_table(table: Table) -> None:
    """Prints a table; wide enough to cut nothing off where the output is not a terminal."""
    console = stdout()
    if not console.is_terminal:
        console.width = 200
    console.print(table)
