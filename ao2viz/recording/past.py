"""A forest at any past moment: which options stood and how, exactly, from the growth log."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.core.growth import GrowthKind
from ao2viz.recording.growth_log import snapshot_arrays
from ao2viz.recording.snapshots import Snapshot, Snapshots


@dataclass(frozen=True, eq=False)
class Moment:
    """A forest as it was after a step."""

    step: int
    view: ForestView  # Weights and visits of the snapshot; 0 where it knows none.
    snapshot: int | None  # The step that weights are from; None: none were kept.


@dataclass(frozen=True, eq=False)
class Past:
    """The life of a forest, to be looked at; `now` is how it ended up.

    Rows are option ids, as everywhere. An option's value never changes, so that of now is that of
    then.
    """

    now: ForestView
    n_steps: int
    steps: NDArray[np.int64]  # [E] of the events, in order.
    kinds: NDArray[np.int8]  # [E]
    options: NDArray[np.int64]  # [E]
    parents: NDArray[np.int64]  # [E]
    snapshots: tuple[Snapshot, ...]
    is_whole: bool  # False: events are missing, so nothing is known exactly.

    def at(self, step: int) -> Moment:
        """The forest after a step; from `n_steps` on it is that of now, as it is.

        Raises:
            ValueError: If the log tells of something that is no forest.
        """
        if step >= self.n_steps:
            return Moment(self.n_steps, self.now, self.n_steps)
        parents, is_alive = self._structure(step)
        weights = np.zeros_like(self.now.weights)
        visits = np.zeros_like(self.now.visits)
        attention = self.now.attention
        known = self._snapshot_before(step)
        if known is not None:
            rows = len(known.weights)
            weights[:rows], visits[:rows] = known.weights, known.visits
            attention = known.attention
        view = ForestView(
            values=self.now.values,
            parents=parents,
            depths=find_depths(parents, is_alive),
            weights=weights,
            visits=visits,
            born=self.now.born,
            is_alive=is_alive,
            links=np.empty((0, 2), np.int64),
            attention=attention,
            revision=int(np.searchsorted(self.steps, step, side="right")),
        )
        return Moment(step, view, None if known is None else known.step)

    @cached_property
    def ever(self) -> ForestView:
        """Every option that there ever was, at its last place: what all moments are drawn on."""
        places = self._places(len(self.steps))
        parents = np.where(self.now.is_alive, self.now.parents, places)
        stood = np.ones(len(parents), np.bool_)
        return ForestView(
            values=self.now.values,
            parents=parents,
            depths=find_depths(parents, stood),
            weights=self.now.weights,
            visits=self.now.visits,
            born=self.now.born,
            is_alive=stood,
            links=np.empty((0, 2), np.int64),
            attention=self.now.attention,
            revision=self.now.revision,
        )

    @cached_property
    def by_end(self) -> NDArray[np.int64]:
        """[N] all options that there ever were: first those that still live, then the others.

        Whoever shows many moments in this order changes few rows from one to the next.
        """
        return np.argsort(~self.now.is_alive, kind="stable")

    def _structure(self, step: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        until = int(np.searchsorted(self.steps, step, side="right"))
        kinds, options = self.kinds[:until], self.options[:until]
        is_alive = np.zeros(len(self.now.parents), np.bool_)
        is_alive[options[kinds == GrowthKind.CREATED]] = True
        is_alive[options[kinds == GrowthKind.REMOVED]] = False
        parents = self._places(until)
        parents[~is_alive] = NO_OPTION
        return parents, is_alive

    def _places(self, until: int) -> NDArray[np.int64]:
        """[N] where each option stood last, by the first so many events."""
        kinds = self.kinds[:until]
        places = np.flatnonzero((kinds == GrowthKind.CREATED) | (kinds == GrowthKind.MOVED))
        parents = np.full(len(self.now.parents), NO_OPTION, np.int64)
        parents[self.options[places]] = self.parents[places]  # Of several the last one counts.
        return parents

    def _snapshot_before(self, step: int) -> Snapshot | None:
        steps = [snapshot.step for snapshot in self.snapshots]
        at = int(np.searchsorted(steps, step, side="right")) - 1
        return self.snapshots[at] if at >= 0 else None


def make_past(now: ForestView, n_steps: int, growth: Mapping[str, NDArray], dropped: int) -> Past:
    """The past of a forest by its growth log, as `GrowthLog.to_arrays` gives it.

    Raises:
        ValueError: If the log tells of options that there are not, or the snapshots of others.
    """
    columns = {name: growth[name] for name in ("step", "kind", "option", "parent")}
    options, n = columns["option"].astype(np.int64), len(now.parents)
    parents = columns["parent"].astype(np.int64)
    if (options >= n).any() or (parents >= n).any():
        raise ValueError(f"Expected a growth log of the {n:,} options of this forest.")
    snapshots = Snapshots.from_arrays(snapshot_arrays(growth)).kept
    for one in snapshots:
        if len(one.weights) > n or one.weights.shape[1:] != now.weights.shape[1:]:
            raise ValueError(f"Expected snapshots of the {n:,} options of this forest.")
        if one.attention.shape != now.attention.shape:
            raise ValueError("Expected snapshots of this forest's features.")
    created = np.count_nonzero(columns["kind"] == GrowthKind.CREATED)
    return Past(
        now=now,
        n_steps=n_steps,
        steps=columns["step"],
        kinds=columns["kind"],
        options=options,
        parents=parents,
        snapshots=snapshots,
        is_whole=dropped == 0 and created == n,
    )


def find_depths(parents: NDArray[np.int64], is_alive: NDArray[np.bool_]) -> NDArray[np.int64]:
    """[N] how far below its root each living option is, 0 for the others.

    Raises:
        ValueError: If parents lead around in a circle.
    """
    has_parent = is_alive & (parents != NO_OPTION)
    # Each round doubles how far every option has climbed; NO_OPTION is kept in the last place.
    climbed = np.append(has_parent, False).astype(np.int64)
    ancestors = np.append(np.where(has_parent, parents, NO_OPTION), NO_OPTION)
    for _ in range(len(parents).bit_length() + 1):
        if (ancestors == NO_OPTION).all():
            return climbed[:-1]
        climbed += climbed[ancestors]
        ancestors = ancestors[ancestors]
    raise ValueError("Expected trees, but the options' parents lead in a circle.")
