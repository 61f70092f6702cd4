"""The command line. Thin: it reads arguments, calls the package, and says what happened.

Rules: results go to stdout, progress and errors to stderr; with `--json`, stdout holds one JSON
value and nothing else. Heavy imports wait until a command needs them, so that help is quick.
"""

from ao2viz.cli.entry import main

__all__ = ["main"]
