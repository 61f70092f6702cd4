"""What learning does to the structure of a forest, one event at a time."""

from enum import IntEnum
from typing import NamedTuple


class GrowthKind(IntEnum):
    """Kinds of growth events; the numbers are part of the file format."""

    CREATED = 0
    """`option` was made as a child of `parent` (NO_OPTION: as a root)."""
    LINKED = 1
    """`option` became a further child of `parent`, beside its place in the tree."""
    REMOVED = 2
    """`option` was cleansed or merged into `parent` (NO_OPTION: into nothing)."""
    MOVED = 3
    """`option` got `parent` as its new place in the tree."""
    ATTENTION = 4
    """The attention weights changed; `option` and `parent` are NO_OPTION."""


class GrowthEvent(NamedTuple):
    """One change of structure, at one step of the agent's life."""

    step: int
    kind: GrowthKind
    option: int
    parent: int
