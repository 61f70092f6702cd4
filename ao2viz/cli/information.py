"""`ao2viz info` and `ao2viz list`: what files hold, without making any environment."""

from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from ao2viz.cli.console import say, say_aside, show_json, show_table
from ao2viz.cli.evaluation import describe_episode, say_outcome
from ao2viz.cli.files import RUNS_FOLDER
from ao2viz.core.config import config_to_dict
from ao2viz.resources import saved_schemas
from ao2viz.store.files import Summary, list_agents, read
from ao2viz.store.saved import SavedAgent


def run(file: Path, *, as_json: bool) -> None:
    """Says what one file holds.

    Raises:
        ValueError: If the file is no agent.
    """
    saved = read(file)
    summary = _describe(file, saved)
    if as_json:
        show_json({**summary, "recorded": [describe_episode(e) for e in saved.episodes]})
        return
    forest = saved.forest_view()
    lines = {
        "Environment": f"{saved.spec.title} ({saved.spec.env_id})",
        "Preset": f"{summary['preset']}, seed {saved.seed}, decides by {summary['decide_by']}",
        "Learned": f"{saved.n_steps:,} steps in {len(saved.history):,} episodes",
        "Forest": f"{summary['options']:,} options in {summary['schemas']:,} schemas, "
        f"{summary['depth']} deep",
        "Actions": ", ".join(saved.spec.action_names),
        "Attention": ", ".join(
            f"{feature.name} {weight:.4g}"
            for feature, weight in zip(saved.spec.features, forest.attention, strict=True)
        ),
        "Settings": ", ".join(f"{name} {value}" for name, value in summary["settings"].items()),
        "File": f"{file}, {summary['bytes']:,} bytes, written {saved.created_at or 'unknown'}",
    }
    for name, value in lines.items():
        say(f"{name:<12} {value}")
    for i, episode in enumerate(saved.episodes, start=1):
        kind = "training" if episode.is_training else "greedy"
        say(f"Episode {i:<4} {kind}, seed {episode.seed}: {say_outcome(episode)}")


def run_list(folder: Path | None, *, as_json: bool) -> None:
    """Lists the agents in a folder; without one, those that ship with ao2viz and those in `runs`.

    A file that cannot be read is listed with the reason; the others are listed all the same.

    Raises:
        NotADirectoryError: If the folder is none.
    """
    if folder is not None and not folder.is_dir():
        raise NotADirectoryError(20, "There is no such folder", str(folder))
    folders = [folder] if folder is not None else [saved_schemas(), RUNS_FOLDER]
    found = [summary for place in folders for summary in list_agents(place)]
    if as_json:
        show_json([_list_entry(summary) for summary in found])
        return
    if not found:
        say_aside(f"No .ao2 files in {' or '.join(str(place) for place in folders)}.")
        return
    table = Table(box=None, pad_edge=False)
    for heading in ("File", "Environment", "Preset"):
        table.add_column(heading, overflow="fold")
    for heading in ("Steps", "Options", "Recorded", "Training return", "Bytes"):
        table.add_column(heading, justify="right")
    for summary in found:
        table.add_row(*_list_cells(summary))
    show_table(table)
    for summary in found:
        if summary.error:
            say_aside(summary.error)


def _list_cells(summary: Summary) -> list[Text]:
    if summary.error:
        return [Text(str(summary.path)), Text("cannot be opened, see below", style="red")]
    mean = "" if summary.mean_return is None else f"{summary.mean_return:.1f}"
    counts = [summary.n_steps, summary.n_options, summary.n_episodes]
    texts = [str(summary.path), summary.env_id, summary.preset, *(f"{n:,}" for n in counts)]
    return [Text(text) for text in [*texts, mean, f"{summary.size:,}"]]


def _list_entry(summary: Summary) -> dict[str, Any]:
    """What the manifest says, in JSON values; a broken file has `error` instead."""
    if summary.error:
        return {"file": str(summary.path), "bytes": summary.size, "error": summary.error}
    return {
        "file": str(summary.path),
        "bytes": summary.size,
        "written": summary.created_at,
        "environment": summary.env_id,
        "title": summary.title,
        "preset": summary.preset,
        "seed": summary.seed,
        "steps": summary.n_steps,
        "options": summary.n_options,
        "recorded_episodes": summary.n_episodes,
        "mean_training_return": summary.mean_return,
    }


def _describe(path: Path, saved: SavedAgent) -> dict[str, Any]:
    """What a file holds, in JSON values."""
    forest = saved.forest_view()
    alive = forest.is_alive
    return {
        "file": str(path),
        "bytes": path.stat().st_size,
        "written": saved.created_at,
        "environment": saved.spec.env_id,
        "title": saved.spec.title,
        "features": [feature.name for feature in saved.spec.features],
        "actions": list(saved.spec.action_names),
        "preset": saved.preset.value,
        "decide_by": saved.config.decide_by.value,
        "seed": saved.seed,
        "settings": config_to_dict(saved.config),
        "attention": forest.attention.tolist(),
        "steps": saved.n_steps,
        "training_episodes": len(saved.history),
        "options": len(forest),
        "schemas": int(np.count_nonzero(alive & (forest.parents < 0))),
        "depth": int(forest.depths[alive].max(initial=-1)) + 1,
        "recorded_episodes": len(saved.episodes),
    }
