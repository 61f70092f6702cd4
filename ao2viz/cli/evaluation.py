"""`ao2viz evaluate` and `ao2viz record`: greedy episodes, counted or kept."""

import statistics
from pathlib import Path
from typing import Any

from ao2viz.agent import AO2
from ao2viz.cli.console import say, show_json, stderr
from ao2viz.cli.files import check_output
from ao2viz.explain.words import say_outcome
from ao2viz.recording.episode import Episode
from ao2viz.training.loop import evaluation_seed


def run(
    file: Path,
    *,
    episodes: int,
    seed: int,
    think_ahead: int | None,
    env: str | None,
    as_json: bool,
) -> None:
    """Plays greedy episodes and says how they went.

    Raises:
        ValueError: If the file is no agent, its environment cannot be made, or it cannot think so.
    """
    agent = AO2.load(file, env)
    if think_ahead is not None:
        agent.set_think_ahead(think_ahead)
    steps_ahead = vars(agent.config).get("think_ahead", 0)
    with stderr().status(f"Playing {_count_episodes(episodes)} of {agent.spec.env_id} …"):
        returns = agent.evaluate(episodes=episodes, seed=seed).tolist()
    summary = summarise_returns(returns)
    if as_json:
        show_json(
            {
                "file": str(file),
                "environment": agent.spec.env_id,
                "seed": seed,
                "decide_by": agent.config.decide_by.value,
                "think_ahead": steps_ahead,
                "episodes": episodes,
                **summary,
                "returns": returns,
            }
        )
        return
    decided = f"deciding by {agent.config.decide_by.value}, evaluation seed {seed}"
    if steps_ahead:
        decided = f"thinking {steps_ahead} step{'' if steps_ahead == 1 else 's'} ahead, {decided}"
    say(f"{agent.spec.env_id}: {_count_episodes(episodes)}, {decided}.")
    say(f"Mean return      {summary['mean']:.2f}")
    if episodes > 1:
        say(f"Std deviation    {summary['std']:.2f}")
        say(f"Standard error   {summary['standard_error']:.2f}")
        say(f"Worst and best   {min(returns):.2f} and {max(returns):.2f}")
    say("Every return     " + " ".join(f"{value:.6g}" for value in returns))


def run_record(
    file: Path,
    *,
    episodes: int,
    seed: int,
    out: Path | None,
    overwrite: bool,
    env: str | None,
    as_json: bool,
) -> None:
    """Records greedy episodes and adds them to the file, or to a copy of it.

    Raises:
        ValueError: If the file is no agent, or its environment cannot be made.
    """
    path = file if out is None else out
    if out is not None:
        check_output(path, overwrite=overwrite)
    agent = AO2.load(file, env)
    with stderr().status(f"Recording {_count_episodes(episodes)} of {agent.spec.env_id} …"):
        recorded = [agent.record_episode(evaluation_seed(seed, i)) for i in range(episodes)]
        agent.save(path)
    if as_json:
        show_json(
            {
                "file": str(path),
                "environment": agent.spec.env_id,
                "recorded": [describe_episode(episode) for episode in recorded],
                "episodes_in_file": len(agent.episodes),
            }
        )
        return
    for episode in recorded:
        say(f"Seed {episode.seed}: {say_outcome(episode)}.")
    held = len(agent.episodes)
    say(f"Saved to {path}, which now holds {held} recorded episode{'' if held == 1 else 's'}.")


def summarise_returns(returns: list[float]) -> dict[str, float | None]:
    """Mean, sample standard deviation and standard error; the last two need two episodes."""
    several = len(returns) > 1
    std = statistics.stdev(returns) if several else None
    return {
        "mean": statistics.fmean(returns),
        "std": std,
        "standard_error": std / len(returns) ** 0.5 if std is not None else None,
    }


def describe_episode(episode: Episode) -> dict[str, Any]:
    """A recorded episode in JSON values, without its steps."""
    return {
        "seed": episode.seed,
        "steps": len(episode),
        "return": episode.total_reward,
        "terminated": episode.terminated,
        "truncated": episode.truncated,
        "is_training": episode.is_training,
    }


def _count_episodes(count: int) -> str:
    return f"{count:,} greedy episode{'' if count == 1 else 's'}"
