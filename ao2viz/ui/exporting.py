"""What is exported from the page, and the work that writes it; pure but for that work."""

import io
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple, assert_never

from ao2viz.core.decision import NO_OPTION
from ao2viz.exports.export import export
from ao2viz.exports.formats import ABOUT, Format, Scope, scopes_of
from ao2viz.store.saved import SavedAgent
from ao2viz.ui.downloads import Notify, SaveFile, stem_of
from ao2viz.ui.jobs import Begin, CalledOffError
from ao2viz.ui.questions import ChooseFormat, ChooseScope, ExportCommand, ExportOption, Task
from ao2viz.ui.questions import Export as ExportNow
from ao2viz.ui.session import Session
from ao2viz.ui.watched import agent_at_rest, episode_of, forest_of
from ao2viz.ui.world import World

MOST_BYTES = 100_000_000
"""Bigger exports are for the command line."""

SUBJECT = ("export",)
"""An export goes on whatever is watched meanwhile."""


@dataclass(frozen=True)
class Export:
    """What would be exported."""

    format: Format
    scope: Scope
    scopes: tuple[Scope, ...]
    problem: str  # Why nothing can be, in words; empty if it can.


def export_of(session: Session, world: World) -> Export:
    """What is chosen, and whether there is something to export."""
    scopes = scopes_of(session.export)
    scope = session.scope if session.scope in scopes else scopes[0]
    return Export(session.export, scope, scopes, _problem(session, world, scope))


def _problem(session: Session, world: World, scope: Scope) -> str:
    if agent_at_rest(session, world) is None:
        if session.source is None and world.update.forest is not None:
            return "Hold the run to export its agent as it is then."
        return "There is no agent to export yet."
    if scope is Scope.AGENT:
        return ""
    if scope is Scope.OPTION:
        forest = forest_of(session, world)
        chosen = session.selected
        if forest is None or chosen == NO_OPTION:
            return "Select an option first: click one on the canvas, or see Inspect."
        if chosen >= len(forest.is_alive) or not forest.is_alive[chosen]:
            return f"Option {chosen} was cleansed; there is nothing of it to export."
        return ""
    if session.branch is not None:
        return (
            "This is a branch, in which you chose an action. What is exported is what the agent "
            "did: go back to the main line."
        )
    episode = episode_of(session, world)
    if episode is None:
        return "This agent has no recorded episode. Record one: ao2viz record FILE."
    if scope is Scope.MOMENT and session.position >= len(episode):
        return "The episode has ended here; step back to a moment with a decision."
    return ""


def take_away(
    session: Session, command: ExportCommand, world: World
) -> tuple[Session, tuple[Notify | Begin, ...]]:
    """The session after a command, and what has to happen outside of it."""
    match command:
        case ChooseFormat(format):
            return replace(session, export=format), ()
        case ChooseScope(scope):
            return replace(session, scope=scope), ()
        case ExportOption():
            return take_away(replace(session, export=Format.OPTION), ExportNow(), world)
        case ExportNow():
            chosen, agent = export_of(session, world), agent_at_rest(session, world)
            if chosen.problem or agent is None:
                return session, (Notify("Cannot export", chosen.problem, is_error=True),)
            of_all = chosen.scope in (Scope.AGENT, Scope.OPTION)
            episode = None if of_all else min(session.episode, len(agent.episodes) - 1)
            step = int(session.position) if chosen.scope is Scope.MOMENT else None
            option = session.selected if chosen.scope is Scope.OPTION else None
            part = _Part(episode, step, option)
            name = f"{stem_of(session, world)}{_tail(chosen.format, part)}"
            return session, (Begin(Task.EXPORT, SUBJECT, _write(agent, chosen, name, part)),)
        case _:
            assert_never(command)


class _Part(NamedTuple):
    """Which part of an agent; None where it is all."""

    episode: int | None
    step: int | None
    option: int | None


def _tail(format: Format, part: _Part) -> str:
    suffix = ABOUT[format].suffix
    if part.option is not None:
        return f"-option-{part.option}{suffix}"
    place = "" if part.episode is None else f"-episode-{part.episode + 1}"
    place += "" if part.step is None else f"-step-{part.step}"
    kind = "" if suffix == f".{format.value}" else f"-{format.value}"
    return f"{place}{kind}{suffix or '.zip'}"


def _write(
    agent: SavedAgent, chosen: Export, name: str, part: _Part
) -> Callable[[Callable[[float], bool]], SaveFile]:
    def work(report: Callable[[float], bool]) -> SaveFile:
        def progress(share: float) -> None:
            if not report(share):
                raise CalledOffError("Called off; nothing was written.")

        with tempfile.TemporaryDirectory(prefix="ao2viz-") as folder:
            path = Path(folder) / f"export{ABOUT[chosen.format].suffix}"
            export(agent, path, chosen.format, **part._asdict(), progress=progress)
            parts = sorted(part for part in [path, *path.rglob("*")] if part.is_file())
            size = sum(part.stat().st_size for part in parts)
            if size > MOST_BYTES:
                raise ValueError(
                    f"This export has {size:,} bytes, more than the {MOST_BYTES:,} that a page "
                    f"hands over. Write it with: ao2viz export FILE --format {chosen.format.value}."
                )
            progress(1.0)
            content = path.read_bytes() if path.is_file() else _zip(path, parts)
        return SaveFile(name, content)

    return work


def _zip(folder: Path, parts: list[Path]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for part in parts:
            archive.write(part, part.relative_to(folder))
    return stream.getvalue()
