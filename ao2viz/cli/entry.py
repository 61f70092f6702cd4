"""From the arguments of a process to its exit code."""

import os
import sys
from collections.abc import Sequence

import typer
from typer.core import TyperGroup
from typer.main import get_command

from ao2viz.cli.commands import app
from ao2viz.cli.console import say_error
from ao2viz.cli.exit_codes import EXIT_FAILED, EXIT_USAGE


def run(arguments: Sequence[str], program: str, command: str | None) -> int:
    """What `ao2viz.cli.main` does, once everything is imported; Ctrl-C passes through."""
    given = list(arguments)
    runnable = get_command(app)
    if command is None:
        given = with_default_command(given)
    elif isinstance(runnable, TyperGroup):
        runnable = runnable.commands[command]
    try:
        try:
            # Not by typer's own `main`, which ends an interrupted command without a word.
            with runnable.make_context(program, given) as context:
                code = runnable.invoke(context)
        except typer.Exit as ended:
            code = ended.exit_code
        sys.stdout.flush()
    except typer.TyperException as error:
        # What typer's own checks call a value error is, for people, just an invalid value.
        message = error.format_message().replace("Value error, ", "")
        say_error(f"{message} ({program} --help lists what there is.)")
        return EXIT_USAGE
    except BrokenPipeError:
        # The reader has left, as `head` does. What Python still flushes at exit goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_FAILED
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        say_error(f"{where}{error.strerror or error}")
        return EXIT_USAGE
    except ValueError as error:
        say_error(str(error))
        return EXIT_USAGE
    return code if isinstance(code, int) else 0


def with_default_command(arguments: list[str]) -> list[str]:
    """Puts `app` in front of what names no command: nothing, app's own options, an .ao2 file."""
    if not arguments:
        return ["app"]
    first = arguments[0]
    own_options = ("--help", "--version")
    is_app_option = first.startswith("-") and first not in own_options
    is_file = first.endswith(".ao2")
    return ["app", *arguments] if is_app_option or is_file else arguments
