"""What is run: every learner on every task of the paper, and the behaviour experiments."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ao2viz.baselines.algorithm import Algorithm
from ao2viz.baselines.zoo import steps_per_update
from ao2viz.core.config import Preset
from ao2viz.experiments.plan import Run, Schedule, Task
from ao2viz.paper.published import ACROBOT, CARTPOLE, ENVS, PENDULUM, TITLES, TRAITS, Learner

FIRST_SEED = 900
"""No setting was chosen by seeds from here on."""


@dataclass(frozen=True)
class Extent:
    """How much is run."""

    share: float  # Of the steps that each learner gets.
    checkpoints: int  # For the curves.
    episodes: int  # At each checkpoint, in each way of deciding.
    seeds: int  # Of AO2, if nobody says otherwise.
    rival_seeds: int


FULL = Extent(share=1.0, checkpoints=8, episodes=100, seeds=5, rival_seeds=3)
QUICK = Extent(share=0.2, checkpoints=4, episodes=20, seeds=2, rival_seeds=1)

# With their settings for Pendulum, our networks were worse there after twice as many steps.
_OURS = {CARTPOLE: 50_000, PENDULUM: 100_000, ACROBOT: 200_000}
_STEPS: Mapping[Learner, Mapping[str, int]] = {
    Preset.PAPER: {CARTPOLE: 200_000, PENDULUM: 300_000, ACROBOT: 100_000},
    Preset.ANTICIPATING: {CARTPOLE: 20_000, PENDULUM: 10_000, ACROBOT: 50_000},
    Algorithm.DAC_A2C: _OURS,
    Algorithm.PPOC: _OURS,
    Algorithm.DAC_PPO: _OURS,
    Algorithm.PPO: _OURS,
    Algorithm.SB3_PPO: {CARTPOLE: 50_000, PENDULUM: 100_000, ACROBOT: 200_000},
    Algorithm.SB3_SAC: {PENDULUM: 10_000},
    Algorithm.SB3_QRDQN: {CARTPOLE: 50_000, ACROBOT: 100_000},
}
_TRAIT_STEPS = 100_000

# Processor seconds for a thousand steps, evaluation included, roughly: for the time left alone.
_SECONDS: Mapping[Learner, float] = {
    Preset.PAPER: 0.4, Preset.ANTICIPATING: 1.5, Algorithm.DAC_A2C: 0.4, Algorithm.PPOC: 0.5,
    Algorithm.DAC_PPO: 0.6, Algorithm.PPO: 0.4, Algorithm.SB3_PPO: 1.2, Algorithm.SB3_SAC: 30.0,
    Algorithm.SB3_QRDQN: 2.8,
}  # fmt: skip


def make_tasks(extent: Extent, seeds: int, rival_seeds: int) -> list[Task]:
    """Everything, the seeds changing slowest: stopped early, all were run on the same ones."""
    tasks = []
    for seed in range(max(seeds, rival_seeds)):
        for learner in TITLES:
            if seed < (seeds if isinstance(learner, Preset) else rival_seeds):
                tasks += [
                    Task(
                        Run(env, learner, "{}", FIRST_SEED + seed), _schedule(learner, env, extent)
                    )
                    for env in ENVS
                    if env in _STEPS[learner]
                ]
        if seed < seeds:
            steps = round(_TRAIT_STEPS * extent.share)
            tasks += [
                Task(
                    Run(PENDULUM, Preset.PAPER, settings, FIRST_SEED + seed),
                    Schedule((steps,), extent.episodes),
                )
                for settings in behaviours()
            ]
    return tasks


def behaviours() -> list[str]:
    """Settings of the behaviour experiments' runs; a flat forest is what the hierarchy meets."""
    # The rule's own value is the preset's default: named, so that it is a run of its own length.
    return [*(trait.settings for trait in TRAITS), FLAT]


FLAT = '{"max_depth": 1}'


def seconds(task: Task) -> float:
    """Processor seconds that a task takes, roughly."""
    return _SECONDS[task.run.preset] * task.schedule.checkpoints[-1] / 1000


def only(tasks: Sequence[Task], names: Sequence[str]) -> list[Task]:
    """The tasks of these learners and environments; all, if none is named.

    Raises:
        ValueError: If a name is none of either.
    """
    learners = {learner.value: learner for learner in TITLES}
    for name in names:
        if name not in learners and name not in ENVS:
            raise ValueError(f"Expected one of {', '.join([*learners, *ENVS])}, but got {name!r}.")
    wanted = [learners[name] for name in names if name in learners]
    envs = [name for name in names if name in ENVS]
    return [
        task
        for task in tasks
        if (not wanted or task.run.preset in wanted) and (not envs or task.run.env in envs)
    ]


def _schedule(learner: Learner, env: str, extent: Extent) -> Schedule:
    """Evenly spread checkpoints, each at the end of an update."""
    unit = steps_per_update(learner, env) if isinstance(learner, Algorithm) else 1
    last = -(-round(_STEPS[learner][env] * extent.share) // unit)
    n = extent.checkpoints
    marks = {max(1, round(last * i / n)) * unit for i in range(1, n + 1)}
    return Schedule(tuple(sorted(marks)), extent.episodes)


def is_main(run: Run) -> bool:
    """Whether a run belongs to the comparison, and not to the behaviour experiments."""
    return not json.loads(run.settings)
