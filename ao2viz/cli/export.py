"""`ao2viz export`: an agent and its recorded decisions in other people's formats."""

from pathlib import Path

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from ao2viz.cli.console import say, show_json, stderr
from ao2viz.cli.files import check_folder
from ao2viz.exports.export import check_path, export
from ao2viz.exports.formats import ABOUT, Format


def run(
    file: Path,
    format: Format,
    *,
    out: Path | None,
    episode: int | None,
    step: int | None,
    option: int | None,
    overwrite: bool,
    env: str | None,
    as_json: bool,
) -> None:
    """Writes one export; Ctrl-C stops it and leaves nothing behind.

    Raises:
        ValueError: If the file is no agent, or does not hold what the format needs.
        OSError: If the export cannot be written.
    """
    path = default_path(file, format) if out is None else out
    check_path(path, format, overwrite=overwrite)
    check_folder(path)
    console = stderr()
    with Progress(
        TextColumn("[bold]{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=console,
        disable=not console.is_terminal,
    ) as progress:
        task = progress.add_task(f"Writing {format.value}", total=1.0)
        export(
            file,
            path,
            format,
            episode=episode,
            step=step,
            option=option,
            overwrite=overwrite,
            env=env,
            progress=lambda share: progress.update(task, completed=share),
        )
    size = sum(part.stat().st_size for part in [path, *path.rglob("*")] if part.is_file())
    if as_json:
        show_json({"file": str(path), "format": format.value, "bytes": size})
    else:
        say(f"Wrote {path} ({format.value}, {size:,} bytes).")


def default_path(file: Path, format: Format) -> Path:
    """Where an export goes if nothing is said: named after the agent, in the working folder."""
    suffix = ABOUT[format].suffix
    if not suffix:
        return Path(f"{file.stem}-{format.value}")
    extra = "" if suffix == f".{format.value}" else f"-{format.value}"
    return Path(f"{file.stem}{extra}{suffix}")
