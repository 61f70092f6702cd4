"""`python app.py [FILE] [--host --port --no-browser]` opens the dashboard, as `ao2viz app` does."""

import sys

from ao2viz.cli import main

if __name__ == "__main__":
    sys.exit(main(program="app.py", command="app"))
