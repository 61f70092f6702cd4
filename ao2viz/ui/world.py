"""What all browsers share and may only read: the shelf of agents, what was opened, the run."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ao2viz.figures.behind import Behind
from ao2viz.store.saved import SavedAgent
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.branches import BranchResult, BranchWish
from ao2viz.ui.defaults import Defaults


@dataclass(frozen=True)
class ShelfItem:
    """An agent file that can be watched."""

    path: Path
    label: str  # Unique on the shelf.
    env_id: str = ""  # Of its task; empty if it cannot be read.


@dataclass(frozen=True)
class LoadFailure:
    """Why a file could not be opened."""

    message: str


@dataclass(frozen=True, eq=False)
class World:
    """One moment of everything that is shared."""

    shelf: tuple[ShelfItem, ...] = ()
    opened: Mapping[Path, SavedAgent | LoadFailure] = field(default_factory=dict)  # Rest: loading.
    update: RunUpdate = field(default_factory=RunUpdate)
    branched: Mapping[BranchWish, BranchResult] = field(default_factory=dict)
    address: str = ""  # What opens this dashboard in a browser.
    folder: Path = field(default_factory=Path.cwd)  # Where agents are saved.
    folders: tuple[Path, ...] = ()  # All that people may choose from for that.
    defaults: Defaults = field(default_factory=dict)  # Settings that agents begin with.
    env_ids: tuple[str, ...] = ()  # Offered for training.
    curves: tuple[Behind, ...] = ()  # How the paper's learners learned.
