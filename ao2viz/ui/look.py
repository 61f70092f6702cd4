"""How one browser wants to see its forest: arrangement, colours, and what is left out."""

from dataclasses import dataclass
from enum import Enum

from ao2viz.figures.charts import SMOOTH_EPISODES, Over
from ao2viz.figures.coloring import Coloring
from ao2viz.figures.palette import Theme


class Arrangement(Enum):
    """Where options stand on the canvas; the values are what people read."""

    DISCS = "discs, from above"
    CONES = "cones, in depth"
    STATE_SPACE = "state space"

    @property
    def is_of_discs(self) -> bool:
        """Whether every schema has a disc of its own, with its root in the middle."""
        return self is not Arrangement.STATE_SPACE


@dataclass(frozen=True)
class Look:
    """What one browser chose to see; two equal ones share their picture of a forest."""

    arrangement: Arrangement = Arrangement.DISCS
    coloring: Coloring = Coloring.ACTION
    axes: tuple[int, ...] = ()  # Two or three features; () before any were chosen: the first.
    deepest: int | None = None  # Options further below their root are hidden; None: none are.
    theme: Theme = Theme.DARK
    is_still: bool = False  # Nothing glides.
    folded: frozenset[int] = frozenset()  # Roots of schemas of which only the root is shown.

    def axes_for(self, n_features: int) -> tuple[int, ...]:
        """The features to use as axes: at least one, none twice, none that is not there."""
        known = tuple(dict.fromkeys(i for i in self.axes if 0 <= i < n_features))
        return known if len(known) > 1 else tuple(range(min(2, n_features)))

    @property
    def is_flat(self) -> bool:
        """Whether everything lies on one plane, to be seen from above."""
        if self.arrangement is Arrangement.STATE_SPACE:
            return len(self.axes) < 3
        return self.arrangement is Arrangement.DISCS


@dataclass(frozen=True)
class ChartLook:
    """How one browser draws the course of training."""

    over: Over = Over.STEPS
    smoothing: int = SMOOTH_EPISODES  # Episodes in the running mean.
    behind: frozenset[str] = frozenset()  # Learners of the paper's comparison, by name.


@dataclass(frozen=True)
class Requests:
    """What a person asked the camera for so far; a number that rises is a new wish."""

    fits: int = 0
    path_focuses: int = 0
    selection_focuses: int = 0
