"""What AO2 learns: several seeds of every task, each evaluated on starts it was never trained on.

Prints the tables of docs/results.md.

    python -m benchmarks.learning --seeds 300:305
"""

import argparse
import os
import time
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import numpy as np

import ao2viz

EPISODES = 100


class Task(NamedTuple):
    """One row of runs."""

    env_id: str
    preset: str
    steps: int


TASKS = (
    Task("CartPole-v0", "anticipating", 5_000),
    Task("CartPole-v1", "anticipating", 20_000),
    Task("Pendulum-v1", "anticipating", 10_000),
    Task("Acrobot-v1", "anticipating", 50_000),
    Task("MountainCar-v0", "anticipating", 20_000),
    Task("CartPole-v0", "paper", 200_000),
    Task("Pendulum-v1", "paper", 300_000),
    Task("Acrobot-v1", "paper", 100_000),
)


class Outcome(NamedTuple):
    """One seed of one task."""

    vote: float  # Mean return of the evaluation episodes, deciding by vote.
    vote_error: float  # Its standard error.
    path: float
    path_error: float
    options: int
    cpu_s: float  # Of learning alone.


def run(task: Task, seed: int) -> Outcome:
    """Trains one agent, then lets it play the same starts as every other."""
    agent = ao2viz.AO2(task.env_id, preset=task.preset, seed=seed)
    started = time.process_time()
    agent.learn(task.steps)
    cpu_s = time.process_time() - started
    figures = []
    for decide_by in ("vote", "path"):
        agent.set_decide_by(decide_by)
        returns = agent.evaluate(EPISODES)
        figures += [returns.mean(), returns.std(ddof=1) / np.sqrt(EPISODES)]
    return Outcome(*figures, len(agent.forest), cpu_s)


def warm(env_id: str) -> None:
    """Compiles before the clock starts."""
    for preset in ("anticipating", "paper"):
        ao2viz.AO2(env_id, preset=preset).learn(400)


def table(task: Task, seeds: range, outcomes: list[Outcome]) -> str:
    """Every seed, then their mean."""
    lines = [
        f"### {task.env_id}, `{task.preset}`, {task.steps:,} steps\n",
        "| seed | by vote | by one path | options | CPU s |",
        "|---|---|---|---|---|",
    ]
    for seed, o in zip(seeds, outcomes, strict=True):
        lines.append(
            f"| {seed} | {o.vote:.1f} ± {o.vote_error:.1f} | {o.path:.1f} ± {o.path_error:.1f} "
            f"| {o.options:,} | {o.cpu_s:.1f} |"
        )
    mean = np.mean(np.array(outcomes), axis=0)
    lines.append(f"| mean | {mean[0]:.1f} | {mean[2]:.1f} | {mean[4]:,.0f} | {mean[5]:.1f} |\n")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="300:305", help="first:past the last")
    parser.add_argument("--only", help="an environment id")
    arguments = parser.parse_args()
    seeds = range(*map(int, arguments.seeds.split(":")))
    tasks = [task for task in TASKS if arguments.only in (None, task.env_id)]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(warm, sorted({task.env_id for task in tasks})))
        jobs = [(task, [pool.submit(run, task, seed) for seed in seeds]) for task in tasks]
        for task, futures in jobs:
            print(table(task, seeds, [future.result() for future in futures]), flush=True)


if __name__ == "__main__":
    main()
