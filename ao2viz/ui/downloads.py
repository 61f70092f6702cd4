"""What a person can take away from the page as a file."""

import io
from dataclasses import dataclass
from typing import assert_never

from ao2viz.core.decision import NO_OPTION
from ao2viz.exports.curves import write_history_csv, write_margins_csv, write_weights_csv
from ao2viz.exports.learner_curves import write_learner_curves_csv
from ao2viz.ui.commands import Table
from ao2viz.ui.learners import learners_of
from ao2viz.ui.session import Session
from ao2viz.ui.watched import agent_of, episode_of, forest_of, history_of, spec_of
from ao2viz.ui.world import World


@dataclass(frozen=True)
class Notify:
    """Tells the person something that has no place of its own on the screen."""

    title: str
    body: str
    is_error: bool = False
    stays: bool = False  # Until it is closed, as errors do.


@dataclass(frozen=True)
class SaveFile:
    """Hands the browser a file to keep."""

    name: str
    content: bytes


def tables_of(session: Session, world: World) -> frozenset[Table]:
    """The tables that there are now."""
    found = set()
    if learners_of(session, world).known:
        found.add(Table.LEARNERS)
    if len(history_of(session, world)):
        found.add(Table.TRAINING)
    episode, forest = episode_of(session, world), forest_of(session, world)
    if spec_of(session, world) is None:
        return frozenset(found)
    if episode is not None and len(episode):
        found.add(Table.EPISODE)
    if forest is not None and 0 <= session.selected < len(forest.parents):
        found.add(Table.OPTION)
    return frozenset(found)


def make_table(table: Table, session: Session, world: World) -> SaveFile | Notify:
    """The table as a file, or in words why there is none."""
    if table not in tables_of(session, world):
        return Notify("Nothing to save", f"There are no {table.value} yet.")
    spec, episode = spec_of(session, world), episode_of(session, world)
    forest, stream = forest_of(session, world), io.BytesIO()
    match table:
        case Table.TRAINING:
            seconds = world.update.seconds[: 0 if session.source is not None else None]
            write_history_csv(history_of(session, world), seconds, stream)
            name = "training"
        case Table.EPISODE:
            assert spec is not None
            assert episode is not None
            write_margins_csv(episode, spec, stream)
            name = f"episode-seed-{episode.seed}"
        case Table.OPTION:
            assert spec is not None
            assert forest is not None
            assert session.selected != NO_OPTION
            write_weights_csv(session.selected, forest, spec, stream)
            name = f"option-{session.selected}"
        case Table.LEARNERS:
            learners = learners_of(session, world)
            write_learner_curves_csv(learners.laid or learners.known, stream)
            name = "learners"
        case _:
            assert_never(table)
    return SaveFile(f"{stem_of(session, world)}-{name}.csv", stream.getvalue())


def stem_of(session: Session, world: World) -> str:
    """Letters, digits, dots and dashes only: it comes from a file, or from an environment's id."""
    agent, spec = agent_of(session, world), spec_of(session, world)
    if agent is not None and session.source is not None:
        name = session.source.stem
    else:
        name = spec.env_id if spec is not None else "run"
    return "".join(c if c.isascii() and (c.isalnum() or c in ".-") else "-" for c in name)[:60]
