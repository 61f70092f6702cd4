"""`ao2viz.export`: an agent out of the app, whole or not at all."""

import os
from pathlib import Path

from ao2viz.agent import AO2
from ao2viz.core.decision import NO_OPTION
from ao2viz.exports.content import Content, Numbered, Progress
from ao2viz.exports.formats import ABOUT, Format
from ao2viz.extras import need
from ao2viz.store.files import read
from ao2viz.store.replacing import replacing, replacing_folder
from ao2viz.store.saved import SavedAgent

AnyPath = str | os.PathLike[str]


def export(
    agent: AO2 | SavedAgent | AnyPath,
    path: AnyPath,
    format: Format | str,
    *,
    episode: int | None = None,
    step: int | None = None,
    option: int | None = None,
    overwrite: bool = False,
    env: str | None = None,
    progress: Progress | None = None,
) -> Path:
    """Writes an agent, or what it did in recorded episodes, in a format that others read.

    Args:
        agent: The agent, or its .ao2 file.
        path: The file to write, or for some formats the folder; folders on the way are made.
        format: One of `Format`, such as "html"; docs/exports.md says what each holds.
        episode: Only this recorded episode, counted from 0. Otherwise all of them, and the latest
            in formats that show one.
        step: The step of that episode, in formats that show one decision.
        option: The id of the option, in formats that show one.
        overwrite: Replaces a file that is there already. A folder is never replaced.
        env: The environment, where the id that the agent knows is not enough: "module:EnvId".
        progress: Told the share that is done, from 0 on, at the end 1; what it raises stops the
            export.

    Returns:
        The path.

    Raises:
        ValueError: If there is no such format, episode or step, something is in the way, or a
            library is missing. One line that says what to do.
        OSError: If it cannot be written. Nothing half is left, and an old file is as it was.
    """
    from ao2viz.exports.writers import FILES, FOLDERS  # noqa: PLC0415 -- heavy.

    kind = to_format(format)
    path = Path(path)
    check_path(path, kind, overwrite=overwrite)
    need("exports", ABOUT[kind].libraries)
    content = choose(agent, episode, step, env, progress, option)
    content.progress(0.0)
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        if ABOUT[kind].is_folder:
            with replacing_folder(path) as folder:
                FOLDERS[kind](content, folder)
                content.progress(1.0)
        else:
            with replacing(path) as stream:
                FILES[kind](content, stream)
                content.progress(1.0)
    except OSError as error:
        # Errors of a full disk name no file, others the one beside that nobody has asked for.
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
    return path


def to_format(format: Format | str) -> Format:
    """The format of this name.

    Raises:
        ValueError: If there is none; names those that are.
    """
    try:
        return Format(format)
    except ValueError:
        names = ", ".join(known.value for known in Format)
        raise ValueError(f"Expected one of the formats {names}, but got {format!r}.") from None


def check_path(path: Path, format: Format, *, overwrite: bool) -> None:
    """Makes sure that nothing is in the way, before any work is done.

    Raises:
        ValueError: If something is; says what to do.
    """
    if not ABOUT[format].is_folder and path.is_dir():
        raise ValueError(f"{path} is a folder; name a file in it.")
    if ABOUT[format].is_folder and path.exists():
        raise ValueError(f"{path} is there already; {format.value} needs a new folder.")
    if path.exists() and not overwrite:
        raise ValueError(f"{path} is there already; name another file or overwrite it.")


def choose(
    agent: AO2 | SavedAgent | AnyPath,
    episode: int | None = None,
    step: int | None = None,
    env: str | None = None,
    progress: Progress | None = None,
    option: int | None = None,
) -> Content:
    """What the writers are given.

    Raises:
        ValueError: If there is no such episode or step.
    """
    if isinstance(agent, AO2):
        saved = agent.to_saved()
    else:
        saved = agent if isinstance(agent, SavedAgent) else read(agent)
    episodes = tuple(Numbered(i, recorded) for i, recorded in enumerate(saved.episodes))
    if episode is not None:
        if not 0 <= episode < len(episodes):
            raise ValueError(f"There is no episode {episode}; {_range(len(episodes), 'episode')}.")
        episodes = episodes[episode : episode + 1]
    if step is not None:
        steps = len(episodes[-1].episode) if episodes else 0
        if not 0 <= step < steps:
            raise ValueError(f"There is no step {step}; {_range(steps, 'step')}.")
    chosen = NO_OPTION if option is None else option
    env_id = env or saved.spec.env_id
    return Content(saved, episodes, step, env_id, _rising(progress or _say_nothing), chosen)


def _range(count: int, noun: str) -> str:
    return f"there are {noun}s 0 to {count - 1}" if count else f"no {noun} is recorded"


def _rising(progress: Progress) -> Progress:
    """Tells a share that is more than all before; writers need not know who told the end."""
    latest = -1.0

    def tell(share: float) -> None:
        nonlocal latest
        if share > latest:
            latest = share
            progress(share)

    return tell


def _say_nothing(share: float) -> None:
    del share
