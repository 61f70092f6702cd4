"""What the share of learning does to training, and how closely it is kept.

    .venv/bin/python -m benchmarks.share [--steps 40000] [--repetitions 5] [ENV or FILE.ao2 …]

Real training in the process that the dashboard trains in, without a browser. Each run trains the
same agent (same seed, or the same file), so every run does the same work; the shares take turns in
every round, so that whatever else the machine does reaches all of them. The first round compiles
and loads what draws, and does not count.

A worker tells for each episode how long learning had taken by its end, updates left out. How much
of the time by the clock that was, is the share that was kept.
"""

import argparse
import math
import os
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ao2viz.training.runner import ProcessRunner
from ao2viz.training.states import MAX_LEARNING, MIN_LEARNING, RunStatus, SetShare, Start
from ao2viz.training.updates import RunUpdate
from benchmarks.machine import describe_run, processor_s

_SHARES = (MAX_LEARNING, 0.95, 0.8, MIN_LEARNING)
"""Those that the page offers."""
_LOOKS_EVERY_S = 0.002
_PATIENCE_S = 600.0
"""Where nothing is compiled yet and others are at work, the first run waits that long."""


@dataclass(frozen=True)
class Speed:
    """How one run went, from its first tenth on to the last update before the end."""

    steps_per_s: float
    learning: float  # Of the time by the clock.
    updates_per_s: float  # Those that arrived.
    cpu: float  # Processor time of the worker, of the time by the clock; NaN if unknown.
    options: int


@dataclass(frozen=True)
class Moment:
    """An update, with what clocks said when it came."""

    update: RunUpdate
    clock_s: float
    cpu_s: float


def measure(runner: ProcessRunner, start: Start, share: float) -> Speed:
    """Trains once."""
    before = runner.latest().run_id
    runner.submit(SetShare(share))
    runner.submit(start)
    moments = [_next(runner, lambda u: u.run_id > before and _is_under_way(u))]
    end = moments[0].update.first_step + start.total_steps
    while (moment := _next(runner, lambda u: u is not moments[-1].update)).update.n_steps < end:
        moments.append(moment)
    # The last one is left out: it may have to wait until what was learned has settled.
    if not moments[1:]:
        raise RuntimeError(f"One update only of {start.total_steps:,} steps; give more --steps.")
    last = _next(runner, lambda u: u.status is RunStatus.FINISHED)
    return _speed(moments[0], moments[-1], len(moments) - 1, last.update)


def _speed(one: Moment, other: Moment, updates: int, last: RunUpdate) -> Speed:
    took = other.clock_s - one.clock_s
    steps_per_s = (other.update.n_steps - one.update.n_steps) / took
    # How long learning took is known for whole episodes, and a step of them stands for all.
    worked_s = other.update.seconds[-1] - one.update.seconds[-1]
    worked_s /= other.update.history[-1, 0] - one.update.history[-1, 0]
    assert last.forest is not None
    return Speed(
        steps_per_s,
        float(steps_per_s * worked_s),
        updates / took,
        (other.cpu_s - one.cpu_s) / took,
        len(last.forest),
    )


def _is_under_way(update: RunUpdate) -> bool:
    """Whether the steps that differ from all others are behind it, and it has ended an episode."""
    is_warm = update.n_steps - update.first_step >= update.total_steps / 10
    return is_warm and bool(np.isfinite(update.seconds[-1:]).any())


def _next(runner: ProcessRunner, is_it: Callable[[RunUpdate], bool]) -> Moment:
    deadline = time.monotonic() + _PATIENCE_S
    while not is_it(update := runner.latest()):
        if update.is_error:
            raise RuntimeError(update.message)
        if time.monotonic() > deadline:
            raise RuntimeError(f"Nothing happened for {_PATIENCE_S:.0f} s.")
        time.sleep(_LOOKS_EVERY_S)
    return Moment(update, time.perf_counter(), processor_s(f"/proc/{runner.pid}"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("agents", metavar="AGENT", nargs="*", default=["CartPole-v1", "Acrobot-v1"])
    parser.add_argument("--steps", type=int, default=40_000)
    parser.add_argument("--repetitions", type=int, default=5)
    arguments = parser.parse_args()
    load = os.getloadavg()[0]
    tables = [
        _rows(Path(agent).stem, _take_turns(agent, arguments.steps, arguments.repetitions))
        for agent in arguments.agents
    ]
    print(describe_run("benchmarks.share"))
    print(
        f"{arguments.steps:,} steps, seed 0, {arguments.repetitions} rounds, load average before "
        f"{load:.1f}; medians, and in brackets least and greatest.\n"
    )
    print(
        f"| agent | share | steps/s | of those at {MAX_LEARNING:.0%} | learning "
        "| updates/s | processor of the worker | steps/s of it |"
    )
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    print("\n".join(row for rows in tables for row in rows))


def _take_turns(agent: str, steps: int, repetitions: int) -> dict[float, list[Speed]]:
    runs: dict[float, list[Speed]] = {share: [] for share in _SHARES}
    is_file = agent.endswith(".ao2")
    start = Start(resume_from=Path(agent)) if is_file else Start(env_id=agent)
    start = replace(start, total_steps=steps)
    runner = ProcessRunner()
    try:
        for i in range(repetitions + 1):
            for share in _SHARES if i % 2 else reversed(_SHARES):
                run = measure(runner, start, share)
                if i > 0:
                    runs[share].append(run)
                print(f"{agent}, {share:.0%}: {run}", file=sys.stderr, flush=True)
    finally:
        runner.close()
    return runs


def _rows(name: str, runs: dict[float, list[Speed]]) -> list[str]:
    rows = []
    for share, group in runs.items():
        most = [run.steps_per_s for run in runs[MAX_LEARNING]]
        ratios = [run.steps_per_s / other for run, other in zip(group, most, strict=True)]
        cells = (
            f"{name}, {group[0].options:,} options",
            f"{share:.0%}",
            _spread([run.steps_per_s for run in group], ",.0f"),
            _spread(ratios, ".2f"),
            _spread([run.learning for run in group], ".1%"),
            f"{statistics.median(run.updates_per_s for run in group):.1f}",
            _spread([run.cpu for run in group], ".0%"),
            _spread([run.steps_per_s / run.cpu for run in group], ",.0f"),
        )
        rows.append("| " + " | ".join(cells) + " |")
    return rows


def _spread(values: Sequence[float], form: str) -> str:
    middle = statistics.median(values)
    if math.isnan(middle):
        return ""
    return f"{middle:{form}} ({min(values):{form}} … {max(values):{form}})"


if __name__ == "__main__":
    main()
