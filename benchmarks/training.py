"""What a step of learning takes, beside a step of the bare environment in the same run.

    .venv/bin/python -m benchmarks.training [--steps 20000] [--repetitions 5] [ENV …]

For each environment: the environment alone under random actions, then each preset learning in
it, alternating, so that whatever else the machine does reaches all of them alike. Shown are
medians over the repetitions, and how many steps of the bare environment a step of learning takes.
It is the time of the processor, on one core: what else the machine does slows it, but is not in it.
"""

import argparse
import gc
import statistics
import time

import gymnasium as gym

from ao2viz import AO2, Preset
from ao2viz.envs.catalogue import CATALOGUE
from benchmarks.machine import describe_run

_COMPILED_BY = 600
"""Steps after which every kernel has been compiled: beyond the warm-up and one sleep."""


def bare_step(env: gym.Env, steps: int, seed: int) -> float:
    """Microseconds that a step of the environment alone takes."""
    env.action_space.seed(seed)
    actions = [env.action_space.sample() for _ in range(steps)]
    env.reset(seed=seed)
    started = time.process_time()
    for action in actions:
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset()
    return 1e6 * (time.process_time() - started) / steps


def learning_step(env_id: str, preset: Preset, steps: int, seed: int) -> tuple[float, int]:
    """Microseconds of a learning step, environment and sleep included; and the options it grew."""
    agent = AO2(env_id, preset=preset, seed=seed)
    started = time.process_time()
    agent.learn(steps)
    return 1e6 * (time.process_time() - started) / steps, len(agent.forest)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("env_ids", metavar="ENV", nargs="*", help="otherwise the catalogue")
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--repetitions", type=int, default=5)
    arguments = parser.parse_args()
    print(describe_run("benchmarks.training"))
    print(f"{arguments.steps:,} steps, seeds 0 to {arguments.repetitions - 1}, medians.\n")
    columns = [f"{p.value}, µs a step | of the bare | options" for p in Preset]
    print(f"| environment | bare, µs a step | {' | '.join(columns)} |")
    print("|---" + "|---:" * (1 + 3 * len(Preset)) + "|")
    for env_id in arguments.env_ids or CATALOGUE:
        print(_row(env_id, arguments.steps, arguments.repetitions), flush=True)


def _row(env_id: str, steps: int, repetitions: int) -> str:
    env = AO2(env_id).env
    for preset in Preset:
        AO2(env_id, preset=preset).learn(_COMPILED_BY)
    bare: list[float] = []
    spent: dict[Preset, list[float]] = {preset: [] for preset in Preset}
    options: dict[Preset, list[int]] = {preset: [] for preset in Preset}
    for seed in range(repetitions):
        gc.collect()
        bare.append(bare_step(env, steps, seed))
        for preset in Preset:
            took, grown = learning_step(env_id, preset, steps, seed)
            spent[preset].append(took)
            options[preset].append(grown)
    alone = statistics.median(bare)
    cells = [env_id, f"{alone:,.1f}"]
    for preset in Preset:
        took = statistics.median(spent[preset])
        grown = statistics.median(options[preset])
        cells += [f"{took:,.0f}", f"{took / alone:.1f}×", f"{grown:,.0f}"]
    return "| " + " | ".join(cells) + " |"


if __name__ == "__main__":
    main()
