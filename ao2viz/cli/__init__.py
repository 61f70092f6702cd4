"""The command line. Thin: it reads arguments, calls the package, and says what happened.

Rules: results go to stdout, progress and errors to stderr; with `--json`, stdout holds one JSON
value and nothing else. Heavy imports wait until a command needs them, so that help is quick.
"""

import sys
from collections.abc import Sequence

from ao2viz.cli.exit_codes import EXIT_INTERRUPTED


def main(
    arguments: Sequence[str] | None = None, program: str = "ao2viz", command: str | None = None
) -> int:
    """Runs one command and returns its exit code; prints one line instead of a traceback.

    Args:
        arguments: Those after the program's name; None takes the process's own.
        program: How the usage lines call the program.
        command: The only command this program has; None: all of them.
    """
    try:
        # In here, as importing takes long enough for somebody to press Ctrl-C meanwhile.
        from ao2viz.cli.entry import run  # noqa: PLC0415

        return run(sys.argv[1:] if arguments is None else arguments, program, command)
    except KeyboardInterrupt:
        print("Error: Interrupted.", file=sys.stderr)  # Whatever draws lines may be half imported.
        return EXIT_INTERRUPTED
