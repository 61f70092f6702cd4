"""`python -m ao2viz` is the `ao2viz` command."""

import sys

from ao2viz.cli import main

if __name__ == "__main__":
    sys.exit(main())
