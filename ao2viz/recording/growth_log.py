"""Every change of a forest's structure, in order, as compact arrays."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.growth import GrowthEvent, GrowthKind
from ao2viz.recording.snapshots import Snapshots

PREFIX = "snapshot_"
"""Stands before the names of the snapshots' arrays among those of the log."""

MAX_EVENTS = 4_000_000
"""The log keeps this many of the newest events; about 68 MB."""

_DTYPE = np.dtype(
    [("step", np.int64), ("kind", np.int8), ("option", np.int32), ("parent", np.int32)]
)


class GrowthLog:
    """The life of a forest: growable, one owner; `to_arrays` gives a frozen copy.

    Events tell all of its structure; `snapshots` keep what it knew at some moments.
    Past `max_events` the oldest half is dropped and counted in `dropped`.
    """

    def __init__(self, max_events: int = MAX_EVENTS) -> None:
        self.dropped = 0
        self.snapshots = Snapshots()
        self._max_events = max_events
        self._events = np.empty(1024, _DTYPE)
        self._count = 0

    def __len__(self) -> int:
        """Events kept."""
        return self._count

    def __iter__(self) -> Iterator[GrowthEvent]:
        """The kept events, the oldest first."""
        for step, kind, option, parent in self._events[: self._count].tolist():
            yield GrowthEvent(step, GrowthKind(kind), option, parent)

    def extend(self, events: Iterable[GrowthEvent]) -> None:
        """Adds what one step of learning changed."""
        for event in events:
            if self._count == len(self._events):
                self._make_room()
            self._events[self._count] = tuple(event)
            self._count += 1

    def to_arrays(self) -> dict[str, NDArray]:
        """Columns `step`, `kind`, `option` and `parent`, one row an event; then the snapshots.

        `from_arrays` reads them.
        """
        kept = self._events[: self._count]
        events = {name: kept[name].copy() for name in _DTYPE.names or ()}
        known = self.snapshots.to_arrays()
        return events | {f"{PREFIX}{name}": array for name, array in known.items()}

    @classmethod
    def from_arrays(cls, arrays: dict[str, NDArray], dropped: int = 0) -> "GrowthLog":
        """The log that `to_arrays` wrote.

        Raises:
            ValueError: If columns differ in length or hold a kind or an id that cannot be, or the
                snapshots are not sound.
        """
        columns = {name: arrays[name] for name in _DTYPE.names or ()}
        count = len(columns["step"])
        if any(column.shape != (count,) for column in columns.values()):
            raise ValueError("Expected the columns of the growth log to be equally long.")
        if count and not (
            np.isin(columns["kind"], list(GrowthKind)).all()
            and (np.diff(columns["step"]) >= 0).all()
            and columns["step"][0] >= 0
            and all((columns[name] >= NO_OPTION).all() for name in ("option", "parent"))
        ):
            raise ValueError(
                "Expected growth events of known kinds, in the order of their steps, with option "
                "ids of at least -1."
            )
        log = cls()
        log.dropped = dropped
        log._events = np.empty(max(count, 1024), _DTYPE)
        for name, column in columns.items():
            log._events[name][:count] = column
        log._count = count
        log.snapshots = Snapshots.from_arrays(snapshot_arrays(arrays))
        return log

    def _make_room(self) -> None:
        keep = self._count
        if 2 * len(self._events) > self._max_events and self._count >= self._max_events:
            keep = self._max_events // 2
            self.dropped += self._count - keep
        size = min(2 * len(self._events), max(self._max_events, 1024))
        grown = np.empty(size, _DTYPE)
        grown[:keep] = self._events[self._count - keep : self._count]
        self._events, self._count = grown, keep


def snapshot_arrays(growth: Mapping[str, NDArray]) -> dict[str, NDArray]:
    """The part of a growth log's arrays that is its snapshots, by their own names."""
    return {
        name.removeprefix(PREFIX): array
        for name, array in growth.items()
        if name.startswith(PREFIX)
    }
