"""Agents with as many options as asked for, each saved once: what big pages are measured with.

They learn Acrobot-v1 with seed 0, as anyone's would, only finer: with `levels` 5 nearly every step
makes an option. Above LARGE attention stays as it was set first and the weights hardly settle, for
both take long there; neither changes how many options there are to draw.
"""

import time
from pathlib import Path

from ao2viz.agent import AO2
from ao2viz.core.growth import GrowthKind
from ao2viz.training.loop import StepResult

LARGE = 200_000
"""Options; agents with more learn with `_HURRIED`."""
ENV_ID = "Acrobot-v1"
FINER = {"levels": 5}
_HURRIED = {"attention_growth": 1000.0, "sleep_sweeps": 5}
_EPISODES = 2


def settings_for(options: int) -> dict[str, float]:
    """The settings that differ from the defaults."""
    return FINER if options <= LARGE else FINER | _HURRIED


def make_agent_file(options: int, folder: Path) -> Path:
    """The file of an agent with at least so many options; made unless it is there already."""
    path = folder / f"{ENV_ID}-{options}.ao2"
    if path.exists():
        return path
    began, living = time.perf_counter(), 0

    def count(result: StepResult) -> bool:
        nonlocal living
        for event in result.events:
            living += (event.kind is GrowthKind.CREATED) - (event.kind is GrowthKind.REMOVED)
        return living < options

    agent = AO2(ENV_ID, seed=0, **settings_for(options))
    agent.learn(100 * options, callback=count)
    for seed in range(1, _EPISODES + 1):
        agent.record_episode(seed)
    folder.mkdir(parents=True, exist_ok=True)
    agent.save(path)
    print(
        f"{path}: {len(agent.forest):,} options after {agent.num_timesteps:,} steps, "
        f"{time.perf_counter() - began:.0f} s",
        flush=True,
    )
    return path
