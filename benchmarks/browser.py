"""How much training slows down when somebody watches: no browser, one, in a thread or a process.

    .venv/bin/python -m benchmarks.browser [--env ENV] [--steps 30000] [--repetitions 5] [--draw]

The real dashboard, the real runners, a real headless Chromium. Each run trains the same agent
(same seed), so every run does the same work; the cases alternate, so that whatever else the
machine does reaches all of them. The run is paused until the browser has settled, then timed.

Two things slow training down: what it has to do so that it can be watched, and the cores that the
page and the browser use. The processor time of the trainer alone (Linux) tells the first apart.
A machine without a graphics card spends a whole core on the browser; --pin keeps that core, and
everything else of the browser, to one half of the cores, and ao2viz to the other, in every case.
"""

import argparse
import contextlib
import os
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from ao2viz.training.runner import ProcessRunner, Runner, ThreadRunner
from ao2viz.training.states import Pause, Resume, RunStatus, Start
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.app import Dashboard
from benchmarks.machine import describe_run, processor_s

_RUNNERS: dict[str, Callable[[], Runner]] = {"thread": ThreadRunner, "process": ProcessRunner}
_PATIENCE_S = 180.0
_SETTLES_S = 4.0
"""What a page needs after it is ready until nothing of opening it is still going on."""


@dataclass(frozen=True)
class Case:
    """One way to train."""

    runner: str
    visitors: int

    def __str__(self) -> str:
        watched = {0: "no browser", 1: "one browser"}.get(
            self.visitors, f"{self.visitors} browsers"
        )
        return f"{self.runner}, {watched}"


class Speed(NamedTuple):
    """How fast one run was, between the moment training resumed and its last step."""

    steps_per_s: float
    cpu_us: float  # Processor time of the trainer, µs a step; NaN where it cannot be known.


def measure(case: Case, env_id: str, steps: int, draw: bool) -> Speed:
    """Trains once."""
    runner = _RUNNERS[case.runner]()
    dashboard = Dashboard(port=0, make_runner=lambda: runner)
    # The dashboard makes its runner at the first click on Start; here a run goes on also where
    # there is no browser to click in.
    dashboard._runner = runner
    with contextlib.redirect_stdout(None):
        dashboard.start()
    try:
        runner.submit(Start(env_id=env_id, total_steps=steps))
        _wait_until(lambda: runner.latest().status is RunStatus.RUNNING)
        runner.submit(Pause())
        _wait_until(lambda: runner.latest().status is RunStatus.PAUSED)
        with contextlib.ExitStack() as stack:
            for _ in range(case.visitors):
                stack.enter_context(_visitor(dashboard.address, draw))
            time.sleep(_SETTLES_S)
            return _time_the_rest(runner)
    finally:
        dashboard.stop()


def _time_the_rest(runner: Runner) -> Speed:
    cpu_before = _cpu_s(runner)
    runner.submit(Resume())
    began, first = time.perf_counter(), runner.latest().n_steps
    ended, last = began, first
    while (update := runner.latest()).status in (RunStatus.PAUSED, RunStatus.RUNNING):
        _refuse_failure(update)
        if update.n_steps > last:
            ended, last = time.perf_counter(), update.n_steps
        if last >= update.total_steps:
            break
        time.sleep(0.005)
    _refuse_failure(runner.latest())
    steps = last - first
    return Speed(steps / (ended - began), 1e6 * (_cpu_s(runner) - cpu_before) / steps)


def _cpu_s(runner: Runner) -> float:
    """Processor time that the trainer has used so far."""
    place = Path("/proc/self/task")
    if isinstance(runner, ProcessRunner):
        place = Path(f"/proc/{runner.pid}")
    else:
        names = {thread.name: thread.native_id for thread in threading.enumerate()}
        place /= str(names["ao2viz training"])
    return processor_s(place)


@contextlib.contextmanager
def _visitor(address: str, draw: bool) -> Iterator[None]:
    command = [sys.executable, "-m", "benchmarks.visitor", address, *(["--draw"] if draw else [])]
    if (cores := os.sched_getaffinity(0)) == _cores_of_ours():  # Pinned: take the others.
        rest = set(range(os.cpu_count() or 1)) - cores
        command = ["taskset", "--cpu-list", ",".join(map(str, sorted(rest))), *command]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        if process.stdout.readline().strip() != "ready":
            raise RuntimeError("The browser did not come up.")
        yield
        process.communicate("")


def _cores_of_ours() -> set[int]:
    """The first half of the cores, for dashboard and training; the browser gets the others."""
    return set(range(max(1, (os.cpu_count() or 1) // 2)))


def _wait_until(is_so: Callable[[], bool]) -> None:
    deadline = time.monotonic() + _PATIENCE_S
    while not is_so():
        if time.monotonic() > deadline:
            raise RuntimeError(f"Nothing happened for {_PATIENCE_S:.0f} s.")
        time.sleep(0.01)


def _refuse_failure(update: RunUpdate) -> None:
    if update.is_error:
        raise RuntimeError(update.message)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--env", default="CartPole-v1")
    parser.add_argument("--steps", type=int, default=30_000)
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--visitors", type=int, default=1)
    parser.add_argument("--draw", action="store_true", help="let Chromium draw, in software")
    parser.add_argument("--pin", action="store_true", help="the browser gets a core of its own")
    arguments = parser.parse_args()
    if arguments.pin:
        os.sched_setaffinity(0, _cores_of_ours())
    cases = [Case(runner, n) for runner in _RUNNERS for n in (0, arguments.visitors)]
    speeds: dict[Case, list[Speed]] = {case: [] for case in cases}
    for i in range(arguments.repetitions + 1):
        for case in cases if i % 2 else reversed(cases):
            speed = measure(case, arguments.env, arguments.steps, arguments.draw)
            if i > 0:  # The first round compiles.
                speeds[case].append(speed)
            said = f"{speed.steps_per_s:,.0f} steps/s, {speed.cpu_us:.0f} µs of processor a step"
            print(f"{case}: {said}", file=sys.stderr, flush=True)
    print(describe_run("benchmarks.browser"))
    drawing = "in software" if arguments.draw else "stubbed"
    drawing += ", browser on cores of its own" if arguments.pin else ""
    print(f"{arguments.env}, {arguments.steps:,} steps, seed 0, drawing {drawing}; medians.\n")
    print("| trained in | alone, steps/s | watched | slower by | every run | alone, µs | watched |")
    print("|---|---:|---:|---:|---|---:|---:|")
    for runner in _RUNNERS:
        print(_row(runner, *(speeds[case] for case in cases if case.runner == runner)))


def _row(runner: str, alone: list[Speed], watched: list[Speed]) -> str:
    ratios = [1 - b.steps_per_s / a.steps_per_s for a, b in zip(alone, watched, strict=True)]
    cells = [
        runner,
        *(f"{statistics.median(s.steps_per_s for s in group):,.0f}" for group in (alone, watched)),
        f"{statistics.median(ratios):.1%}",
        ", ".join(f"{ratio:.1%}" for ratio in ratios),
        *(f"{statistics.median(s.cpu_us for s in group):,.0f}" for group in (alone, watched)),
    ]
    return "| " + " | ".join(cells) + " |"


if __name__ == "__main__":
    main()
