"""What an experiment consists of: runs, and when each is evaluated; checked before any begins."""

import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ao2viz.agent import AO2
from ao2viz.baselines.algorithm import Acting, Algorithm
from ao2viz.core.config import Preset, config_to_dict
from ao2viz.core.decision import DecideBy

Learner = Preset | Algorithm
"""AO2 with one of its presets, or what it is compared with."""

Way = DecideBy | Acting
"""How an agent is asked: AO2 in the one, a network in the other."""

MAX_RUNS = 100_000
"""More are a slip of the keyboard."""


@dataclass(frozen=True)
class Run:
    """One agent to train; equal runs give equal agents."""

    env: str  # What `gymnasium.make` takes.
    preset: Learner
    settings: str  # JSON object of what differs from the proven settings, by name.
    seed: int

    @property
    def overrides(self) -> dict[str, Any]:
        """The settings as `AO2` takes them."""
        return json.loads(self.settings)

    @property
    def ways(self) -> tuple[Way, ...]:
        """In which it is evaluated."""
        return tuple(DecideBy if isinstance(self.preset, Preset) else Acting)

    def __str__(self) -> str:
        return f"{self.env} {self.preset.value}{say_settings(self.settings)} seed {self.seed}"


@dataclass(frozen=True)
class Schedule:
    """When each run is evaluated, and how thoroughly."""

    checkpoints: tuple[int, ...]  # Steps learned from by then, rising; the last ends the run.
    episodes: int  # Greedy episodes for each way of deciding.


@dataclass(frozen=True)
class Task:
    """Something to do."""

    run: Run
    schedule: Schedule


def make_schedule(steps: int, checkpoints: Iterable[int], episodes: int) -> Schedule:
    """A schedule that ends, and evaluates last, after `steps`.

    Raises:
        ValueError: If a checkpoint is not from 1 to `steps`, or a number is below 1.
    """
    for name, number in (("steps", steps), ("episodes", episodes)):
        if number < 1:
            raise ValueError(f"Expected at least 1 as {name}, but got {number}.")
    wanted = sorted({*checkpoints, steps})
    if wanted[0] < 1 or wanted[-1] > steps:
        wrong = wanted[0] if wanted[0] < 1 else wanted[-1]
        raise ValueError(f"Expected checkpoints from 1 to {steps:,} (--steps), but got {wrong:,}.")
    return Schedule(tuple(wanted), episodes)


def make_runs(
    envs: Sequence[str],
    preset: Preset,
    grid: Mapping[str, Sequence[Any]],
    seeds: Sequence[int],
) -> list[Run]:
    """Every environment with every combination of settings and every seed, each once.

    The seeds change slowest, so that an experiment that is stopped early has compared everything
    on the same seeds.

    Args:
        envs: Gymnasium ids, "module:EnvId" included.
        preset: Of all runs.
        grid: Values to try, by setting; empty for the proven settings alone.
        seeds: Whole numbers from 0 on.

    Raises:
        ValueError: If nothing is asked for, too much, an environment cannot be made or does not
            fit, or a setting is unknown or out of range.
    """
    n_settings = 1
    for values in grid.values():
        n_settings *= len(values)
    count = len(envs) * n_settings * len(seeds)
    if not 0 < count <= MAX_RUNS:
        raise ValueError(f"Expected 1 to {MAX_RUNS:,} runs, but these are {count:,}.")
    if not all(0 <= seed < 2**63 for seed in seeds):
        raise ValueError(f"Expected seeds from 0 on, but got {min(seeds)} to {max(seeds)}.")
    combinations = [
        dict(zip(grid, values, strict=True)) for values in itertools.product(*grid.values())
    ]
    agents = [
        (env, _check(env, preset, overrides, seeds[0]))
        for env in envs
        for overrides in combinations
    ]
    return list(
        dict.fromkeys(
            Run(env, preset, settings, seed) for seed in seeds for env, settings in agents
        )
    )


def say_settings(settings: str) -> str:
    """Settings in words, with a space in front; empty if nothing differs."""
    return "".join(f" {name}={value}" for name, value in json.loads(settings).items())


def _check(env: str, preset: Preset, overrides: Mapping[str, Any], seed: int) -> str:
    """The settings as the agent understood them: 3 and 3.0 levels are the same."""
    agent = AO2(env, preset, seed, **overrides)
    understood = {**config_to_dict(agent.config), "action_bins": agent.spec.action_bins}
    agent.env.close()
    return json.dumps({name: understood[name] for name in sorted(overrides)})
