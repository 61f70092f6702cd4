"""How long a move of the slider over training takes, in a forest of many growth events.

    .venv/bin/python -m benchmarks.past [--events 100000] [--moves 40]

The forest is made by hand: a third of the events are moves and removals, as regrowing causes
them. A move is all that the dashboard's loop does for it: the structure of that moment, its
picture, and handing every changed chunk to a browser's connection. The wire and the browser are
not in it. Beside the time on the clock stands the processor time of the loop, which other work on
the machine does not lengthen.
"""

import argparse
import statistics
import time

import numpy as np

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.core.growth import GrowthKind
from ao2viz.envs.task import describe, make_env
from ao2viz.recording.past import Past, find_depths, make_past
from ao2viz.recording.snapshots import Snapshots
from ao2viz.ui.gallery import Gallery
from ao2viz.ui.look import Look
from ao2viz.ui.scene import Canvas, prepare
from ao2viz.ui.security import make_server
from benchmarks.machine import describe_run


def make_life(events: int, seed: int = 0) -> Past:
    """A forest whose log has so many events: options made, some moved, some removed."""
    rng = np.random.default_rng(seed)
    n = events * 2 // 3
    parents = np.where(np.arange(n) < 100, NO_OPTION, rng.integers(0, 100, n))
    others = np.sort(rng.choice(np.arange(200, n), events - n, replace=False))
    kinds = np.full(n, GrowthKind.CREATED, np.int8)
    moved = np.where(rng.random(len(others)) < 0.5, int(GrowthKind.MOVED), int(GrowthKind.REMOVED))
    when = np.minimum(others + rng.integers(1, n // 4, len(others)), n)
    steps = np.concatenate([np.arange(n), when])
    order = np.argsort(steps, kind="stable")
    options = np.concatenate([np.arange(n), others])
    targets = np.concatenate([parents, rng.integers(0, 100, len(others))])
    kinds = np.concatenate([kinds, moved.astype(np.int8)])
    is_alive, last = np.ones(n, np.bool_), parents.copy()
    gone = others[moved == GrowthKind.REMOVED]
    is_alive[gone] = False
    kept = moved == GrowthKind.MOVED
    last[others[kept]] = targets[n:][kept]
    last = np.where(is_alive, last, NO_OPTION)
    now = ForestView(
        values=rng.normal(size=(n, 4)),
        parents=last,
        depths=find_depths(last, is_alive),
        weights=rng.normal(size=(n, 2)),
        visits=rng.integers(0, 50, (n, 2)),
        born=np.arange(n),
        is_alive=is_alive,
        links=np.empty((0, 2), np.int64),
        attention=np.ones(4),
        revision=events,
    )
    log = {
        "step": steps[order],
        "kind": kinds[order],
        "option": options[order],
        "parent": targets[order],
    }
    snapshots = Snapshots()
    for step in range(0, n, snapshots.stride):
        if snapshots.is_due(step):
            rows = slice(0, step)
            view = ForestView(
                **{**vars(now), "weights": now.weights[rows], "visits": now.visits[rows]}
            )
            snapshots.take(view, step)
    log |= {f"snapshot_{name}": array for name, array in snapshots.to_arrays().items()}
    return make_past(now, n, log, 0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--events", type=int, default=100_000)
    parser.add_argument("--moves", type=int, default=40)
    arguments = parser.parse_args()
    past = make_life(arguments.events)
    spec, gallery, look = describe(make_env("CartPole-v1")), Gallery(), Look()
    server = make_server("127.0.0.1", 0)
    prepare(server.scene)
    canvas = Canvas(server)  # pyright: ignore[reportArgumentType]  Its scene is all that is used.
    taken: dict[str, list[float]] = {"structure": [], "picture": [], "hand over": []}
    taken |= {"move": [], "move, processor": []}
    began = time.perf_counter()
    last = past.at(past.n_steps - 1).view
    while gallery.get_past(("past", "", 0), past, last, spec, look) is None:
        time.sleep(0.001)
    first = time.perf_counter() - began
    for step in np.random.default_rng(1).integers(0, past.n_steps, arguments.moves).tolist():
        times, cpu = [time.perf_counter()], time.thread_time()
        view = past.at(step).view
        times.append(time.perf_counter())
        picture = gallery.get_past(("past", "", 0), past, view, spec, look)
        times.append(time.perf_counter())
        canvas.sync(picture, None, None)
        while canvas.is_busy:
            canvas.sync(picture, None, None)
        times.append(time.perf_counter())
        for name, duration in zip(taken, np.diff(times), strict=False):
            taken[name].append(float(duration))
        taken["move"].append(times[-1] - times[0])
        taken["move, processor"].append(time.thread_time() - cpu)
    server.stop()
    print(describe_run("benchmarks.past"))
    print(f"{arguments.events:,} events, {len(past.now.parents):,} options ever, seeds 0 and 1.\n")
    print("| part of a move | median, ms | longest, ms |")
    print("|---|---:|---:|")
    for name, durations in taken.items():
        print(f"| {name} | {1e3 * statistics.median(durations):.0f} | {1e3 * max(durations):.0f} |")
    print(f"\nThe first look at the past, which arranges every option once: {first:.1f} s.")


if __name__ == "__main__":
    main()
