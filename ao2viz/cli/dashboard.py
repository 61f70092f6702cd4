"""`ao2viz app`: the dashboard, on an agent of one's own or a bundled one."""

from collections.abc import Sequence
from pathlib import Path

from ao2viz.cli.console import say
from ao2viz.cli.files import RUNS_FOLDER
from ao2viz.store.files import read


def run(
    file: Path | None,
    moment: tuple[int | None, int | None] = (None, None),
    *,
    host: str,
    port: int,
    open_browser: bool,
    folders: Sequence[Path] = (),
    curves: Path | None = None,
) -> None:
    """Serves until Ctrl-C; agents go to the first folder unless another is chosen.

    `moment` is the episode and step to open, counted from 0.

    Raises:
        ValueError: If the file is no agent, there is no such moment in it, a folder is something
            else, or there are no learning curves in `curves`.
        OSError: If it cannot be read, or the address cannot be listened on.
    """
    saved = None
    if file is not None:
        # What is wrong is told here, in the terminal, before any page opens.
        saved = read(file)
        _check(moment, [len(episode) for episode in saved.episodes])
    allowed = [folder.resolve() for folder in folders] or [RUNS_FOLDER.resolve()]
    for folder in allowed:
        if folder.exists() and not folder.is_dir():
            raise ValueError(f"Expected --folder to be a folder, but {folder} is something else.")
    from ao2viz.exports.learner_curves import read_learner_curves  # noqa: PLC0415 -- heavy.
    from ao2viz.ui.app import serve  # noqa: PLC0415
    from ao2viz.ui.session import Wanted  # noqa: PLC0415

    wanted = None if moment == (None, None) else Wanted(*moment)
    laid = None if curves is None else read_learner_curves(curves)
    try:
        more = tuple(allowed[1:])
        serve(
            file,
            host,
            port,
            open_browser,
            folder=allowed[0],
            more_folders=more,
            wanted=wanted,
            curves=laid,
            saved=saved,
        )
    except KeyboardInterrupt:
        say("Stopped.")


def _check(moment: tuple[int | None, int | None], lengths: list[int]) -> None:
    episode, step = moment
    if moment == (None, None):
        return
    if not lengths:
        raise ValueError("This agent has no recorded episodes; record some with ao2viz record.")
    if (episode or 0) >= len(lengths):
        known = len(lengths) - 1
        raise ValueError(f"There is no recorded episode {episode}; they go from 0 to {known}.")
    if (step or 0) > lengths[episode or 0]:
        known = lengths[episode or 0]
        raise ValueError(f"There is no step {step} in that episode; they go from 0 to {known}.")
