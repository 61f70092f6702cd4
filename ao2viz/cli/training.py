"""`ao2viz train`: an agent learns, and whatever happens, what it learned is saved."""

import json
import re
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

from ao2viz.agent import AO2
from ao2viz.cli.console import say, say_aside, say_error, show_json, stderr
from ao2viz.cli.exit_codes import EXIT_FAILED
from ao2viz.cli.files import RUNS_FOLDER, check_output
from ao2viz.cli.interrupts import DeferredInterrupts
from ao2viz.core.config import Preset
from ao2viz.store.files import SUFFIX
from ao2viz.training.loop import StepResult

_RECENT = 20
"""Episodes whose mean return is shown."""
_REDRAW_S = 0.1


def run(
    env: str,
    *,
    steps: int,
    preset: Preset | None,
    seed: int | None,
    out: Path | None,
    settings: Sequence[str],
    overwrite: bool,
    env_id: str | None,
    as_json: bool,
) -> int:
    """Trains, saves, and sums up; returns the exit code.

    Raises:
        ValueError: If environment, file or settings do not fit, or the file to save to is there
            already.
    """
    overrides = parse_settings(settings)
    if env.endswith(SUFFIX):
        path = Path(env) if out is None else out
        check_output(path, overwrite=overwrite)
        agent = _go_on_with(Path(env), env_id, preset, seed, overrides)
    elif env_id is not None:
        raise ValueError("--env is for files to go on with; a new agent gets it as ENV.")
    else:
        preset, seed = preset or Preset.ANTICIPATING, seed or 0
        path = default_path(env, preset, seed) if out is None else out
        check_output(path, overwrite=overwrite)
        agent = AO2(env, preset=preset, seed=seed, **overrides)
    steps_before = agent.num_timesteps
    started = time.perf_counter()
    failure: Exception | None = None
    with DeferredInterrupts(
        lambda: say_aside("Stopping after this step, then saving. Ctrl-C again quits at once.")
    ) as interrupts:
        with _Display(agent, steps) as display:

            def after_step(_: StepResult) -> bool:
                display.show_step()
                return interrupts.received is None

            try:
                agent.learn(steps, callback=after_step)
            except Exception as error:
                failure = error  # An environment may raise anything; what was learned stays.
                agent.settle()
        seconds = time.perf_counter() - started
        path = _save(agent, path)
    exit_code = interrupts.exit_code
    if failure is not None:
        exit_code = EXIT_FAILED
        say_error(
            f"Training failed after {agent.num_timesteps:,} steps: {type(failure).__name__}: "
            f"{failure} What was learned until then is in {path}."
        )
    elif exit_code:
        taken = agent.num_timesteps - steps_before
        say_aside(f"Stopped after {taken:,} of {steps:,} steps; saved to {path}.")
    summary = _summarise(agent, path, steps, steps_before, seconds)
    if as_json:
        show_json(summary)
    else:
        _say_summary(summary)
    return exit_code


def _go_on_with(
    path: Path,
    env_id: str | None,
    preset: Preset | None,
    seed: int | None,
    overrides: dict[str, Any],
) -> AO2:
    if preset is not None or seed is not None:
        raise ValueError(
            f"{path} has its own preset and seed; leave out --preset and --seed to go on with it."
        )
    agent = AO2.load(path, env_id)
    agent.change_settings(**overrides)
    return agent


def parse_settings(settings: Sequence[str]) -> dict[str, Any]:
    """Reads `NAME=VALUE` pairs; values are JSON where they can be, else plain words.

    Raises:
        ValueError: If one is no pair, or belongs to an option of its own.
    """
    parsed: dict[str, Any] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        if not (equals and name):
            raise ValueError(f"Expected --set NAME=VALUE, such as levels=4, but got {setting!r}.")
        if name in ("env", "preset", "seed"):
            raise ValueError(
                f"{name!r} is no setting of the preset; give it as ENV, --preset or --seed."
            )
        try:
            parsed[name] = json.loads(text)
        except json.JSONDecodeError:
            parsed[name] = text
    return parsed


def default_path(env: str, preset: Preset, seed: int) -> Path:
    """Where `train` saves if it is not told: in `runs`, named after what was trained."""
    name = re.sub(r"[^A-Za-z0-9.-]+", "_", env)
    return RUNS_FOLDER / f"{name}-{preset.value}-seed{seed}.ao2"


def _save(agent: AO2, path: Path) -> Path:
    """Saves, in the folder for temporary files if all else fails: nothing learned is lost.

    Raises:
        OSError: If not even that works.
    """
    try:
        agent.save(path)
    except OSError as error:
        instead = Path(tempfile.mkdtemp(prefix="ao2viz-")) / path.name
        say_error(f"Could not save to {path}: {error.strerror or error}. Saving to {instead}.")
        agent.save(instead)
        return instead
    return path


class _Display:
    """The progress line: bar, steps a second, time to go, recent returns and options."""

    def __init__(self, agent: AO2, steps: int) -> None:
        console = stderr()
        self._agent = agent
        self._steps = steps
        self._taken = 0
        self._drawn_at = self._started = time.perf_counter()
        self._progress = Progress(
            TextColumn("[bold]{task.description}"),
            BarColumn(),
            TextColumn("{task.completed:,.0f}/{task.total:,.0f} steps"),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[note]}"),
            console=console,
            disable=not console.is_terminal,
        )
        self._task: TaskID = self._progress.add_task("Compiling", total=steps, rate="", note="")

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def show_step(self) -> None:
        """Counts a step; draws at most every tenth of a second."""
        self._taken += 1
        now = time.perf_counter()
        if now - self._drawn_at < _REDRAW_S and self._taken < self._steps:
            return
        self._drawn_at = now
        recent = self._agent.history.summaries[-_RECENT:]
        note = ""
        if recent:
            mean = sum(episode.total_reward for episode in recent) / len(recent)
            note = f"return {mean:.1f} · {recent[-1].options:,} options"
        self._progress.update(
            self._task,
            completed=self._taken,
            description="Settling" if self._taken == self._steps else "Learning",
            rate=f"{self._taken / (now - self._started):,.0f} steps/s",
            note=note,
        )


def _summarise(
    agent: AO2, path: Path, steps: int, steps_before: int, seconds: float
) -> dict[str, Any]:
    recent = [episode.total_reward for episode in agent.history.summaries[-_RECENT:]]
    return {
        "file": str(path),
        "environment": agent.spec.env_id,
        "preset": agent.preset.value,
        "seed": agent.seed,
        "steps": agent.num_timesteps,
        "steps_before": steps_before,
        "steps_asked": steps,
        "seconds": round(seconds, 3),
        "steps_per_s": round((agent.num_timesteps - steps_before) / seconds, 1),
        "episodes": len(agent.history),
        "options": len(agent.forest),
        "recent_mean_return": sum(recent) / len(recent) if recent else None,
    }


def _say_summary(summary: dict[str, Any]) -> None:
    before = f" after {summary['steps_before']:,} earlier ones" if summary["steps_before"] else ""
    say(
        f"{summary['environment']}, {summary['preset']}, seed {summary['seed']}: "
        f"{summary['steps'] - summary['steps_before']:,} steps{before} in "
        f"{summary['seconds']:,.1f} s "
        f"({summary['steps_per_s']:,.0f} a second), {summary['episodes']:,} episodes, "
        f"{summary['options']:,} options."
    )
    if summary["recent_mean_return"] is not None:
        count = min(_RECENT, summary["episodes"])
        say(
            f"Mean return of the last {count} training episodes, exploration included: "
            f"{summary['recent_mean_return']:.1f}."
        )
    say(f"Saved to {summary['file']}.")
    say(f"To see it: ao2viz {summary['file']}   To measure it: ao2viz evaluate {summary['file']}")
