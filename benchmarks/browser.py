"""How much training slows down when somebody watches: no browser, one, in a thread or a process.

    .venv/bin/python -m benchmarks.browser [--env ENV] [--steps 30000] [--repetitions 5] [--draw]

The real dashboard, the real runners, a real headless Chromium. Each run trains the same agent
(same seed), so every run does the same work; the cases alternate, so that whatever else the
machine does reaches all of them. The run is paused until the browser has settled, then timed.
"""

import argparse
import contextlib
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ao2viz.training.runner import ProcessRunner, Runner, ThreadRunner
from ao2viz.training.states import Pause, Resume, RunStatus, Start
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.app import Dashboard
from benchmarks.machine import describe_run

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


def measure(case: Case, env_id: str, steps: int, draw: bool) -> float:
    """Steps a second between the moment training resumes and its last step."""
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


def _time_the_rest(runner: Runner) -> float:
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
    return (last - first) / (ended - began)


@contextlib.contextmanager
def _visitor(address: str, draw: bool) -> Iterator[None]:
    command = [sys.executable, "-m", "benchmarks.visitor", address, *(["--draw"] if draw else [])]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        if process.stdout.readline().strip() != "ready":
            raise RuntimeError("The browser did not come up.")
        yield
        process.communicate("")


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
    arguments = parser.parse_args()
    cases = [Case(runner, n) for runner in _RUNNERS for n in (0, arguments.visitors)]
    rates: dict[Case, list[float]] = {case: [] for case in cases}
    for i in range(arguments.repetitions + 1):
        for case in cases if i % 2 else reversed(cases):
            rate = measure(case, arguments.env, arguments.steps, arguments.draw)
            if i > 0:  # The first round compiles.
                rates[case].append(rate)
            print(f"{case}: {rate:,.0f}", file=sys.stderr, flush=True)
    print(describe_run("benchmarks.browser"))
    drawing = "in software" if arguments.draw else "stubbed"
    print(f"{arguments.env}, {arguments.steps:,} steps, seed 0, drawing {drawing}.\n")
    print("| trained in | without a browser, steps/s | with | slower by | every ratio |")
    print("|---|---:|---:|---:|---|")
    for runner in _RUNNERS:
        alone, watched = rates[Case(runner, 0)], rates[Case(runner, arguments.visitors)]
        ratios = [1 - b / a for a, b in zip(alone, watched, strict=True)]
        print(
            f"| {runner} | {statistics.median(alone):,.0f} | {statistics.median(watched):,.0f} "
            f"| {statistics.median(ratios):.1%} | {', '.join(f'{r:.1%}' for r in ratios)} |"
        )


if __name__ == "__main__":
    main()
