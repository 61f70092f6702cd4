"""What the exit code of a command means; `docs/cli.md` says it to people."""

EXIT_FAILED = 1
"""The work itself failed, for example an environment that raised in the middle of training."""
EXIT_USAGE = 2
"""Asked for something that cannot be: bad flags, missing or broken files, unknown names."""
EXIT_INTERRUPTED = 130
"""Ctrl-C, as shells count it: 128 and the signal's number."""
