"""Compiled code: what a change reaches, and what others may do while it runs."""

import shutil
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np

import ao2viz
from ao2viz.core.index import make_index

ASK = """
import numpy as np
from ao2viz.core.forest import Forest
from ao2viz.core.inference import trace_paths
forest = Forest(1, 1, np.ones(1))
forest.add(np.array([3.0]), -1, 0)
paths, distances = np.zeros((1, 1), np.int64), np.zeros((1, 1))
trace_paths(forest.columns, np.array([1.0]), np.array([0]), paths, distances)
print(distances[0, 0])
"""


def ask(folder):
    done = subprocess.run(
        [sys.executable, "-c", ASK], cwd=folder, capture_output=True, text=True, check=True
    )
    return float(done.stdout)


def test_an_upgraded_file_is_not_answered_with_code_compiled_before(tmp_path):
    package = Path(ao2viz.__file__).parent
    shutil.copytree(package, tmp_path / "ao2viz", ignore=shutil.ignore_patterns("__pycache__"))
    assert ask(tmp_path) == 2.0
    columns = tmp_path / "ao2viz" / "core" / "columns.py"
    text = columns.read_text()
    # `trace_paths` stands in another file, and its cached code has `distance` inside.
    assert text.count("total += abs(") == 1
    columns.write_text(text.replace("total += abs(", "total += 10 * abs("))
    assert ask(tmp_path) == 20.0


def test_other_threads_run_while_a_big_forest_is_indexed():
    points = np.random.default_rng(0).random((200_000, 4))
    options = np.arange(len(points))
    make_index(points, options)  # Compiled, once: what remains is the work itself.
    turns, stopping = [], threading.Event()

    def take_turns():
        while not stopping.wait(0.0005):
            turns.append(None)

    other, before = threading.Thread(target=take_turns), sys.getswitchinterval()
    other.start()
    # Nobody is asked to let others run any more; who does so does it of its own accord.
    sys.setswitchinterval(1_000)
    try:
        seen = len(turns)
        make_index(points, options)
        taken = len(turns) - seen
    finally:
        sys.setswitchinterval(before)
        stopping.set()
        other.join()
    assert taken > 3
