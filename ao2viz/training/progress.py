"""How far learning is, as a bar in the terminal."""

import contextlib
from collections.abc import Callable, Iterator


@contextlib.contextmanager
def advancing(total: int, *, is_shown: bool) -> Iterator[Callable[[int], None]]:
    """Gives what is to be called with how many steps were taken; a bar only if it is shown."""
    if not is_shown:
        yield lambda steps: None
        return
    from rich.progress import Progress  # noqa: PLC0415  Slow to import, rarely needed.

    with Progress() as progress:
        task = progress.add_task("Learning", total=total)
        yield lambda steps: progress.advance(task, steps)
