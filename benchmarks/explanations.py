"""How long an explanation takes: why, why not, all single flips, radius, novelty, the solver.

    .venv/bin/python -m benchmarks.explanations [--states 40] [--time-limit 10]

On the bundled agents, at states of their recorded episodes, evenly spread. Processor time of one
core in milliseconds, median and greatest; of the solver seconds, and how many searches ended.
"""

import argparse
import statistics
import time
from collections.abc import Callable

import numpy as np

from ao2viz.agent import AO2
from ao2viz.core.decision import Decision
from ao2viz.explain.radius import certify
from ao2viz.resources import saved_schemas
from benchmarks.machine import describe_run


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=40)
    parser.add_argument("--time-limit", type=float, default=10.0)
    settings = parser.parse_args()
    print(describe_run("benchmarks.explanations"))
    print("| agent | options | why | why not | flips | radius | mind | nearest flip, s | ended |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|")
    for path in sorted(saved_schemas().glob("*.ao2")):
        agent = AO2.load(path)
        explain = agent.explain
        decisions = [d for episode in agent.episodes for d in episode.decisions]
        places = np.linspace(0, len(decisions) - 1, settings.states).astype(int)
        asked = [decisions[place] for place in places]
        explain.flips(asked[0])  # Compiles.
        explain.nearest_flip(asked[0], settings.time_limit)
        kinds: list[Callable[[Decision], object]] = [
            explain.why,
            lambda d, explain=explain: explain.why_not(d, d.runner_up_action),
            explain.flips,
            lambda d, mind=explain.mind: certify(mind, d.observation),
            lambda _, agent=agent: agent.explain,
        ]
        cells = [time_all(kind, asked) for kind in kinds]
        times, searches = [], []
        for decision in asked:
            started = time.process_time()
            searches.append(explain.nearest_flip(decision, settings.time_limit))
            times.append(time.process_time() - started)
        ended = sum(search.is_complete for search in searches)
        solver = f"{statistics.median(times):.2f} ({max(times):.1f})"
        name, options = agent.spec.env_id, f"{len(agent.forest):,}"
        print(
            f"| {name} | {options} | {' | '.join(cells)} | {solver} | {ended} of {len(asked)} |",
            flush=True,
        )


def time_all(kind: Callable[[Decision], object], asked: list[Decision]) -> str:
    """Median and greatest processor time of one kind of question, as a table's cell."""
    times = []
    for decision in asked:
        started = time.process_time()
        kind(decision)
        times.append(1e3 * (time.process_time() - started))
    return f"{statistics.median(times):.1f} ({max(times):.1f})"


if __name__ == "__main__":
    main()
