"""The active schemas in full, over a forest that is too big to be drawn in full."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.ui.detail import MOST_SHAPES, Detail
from ao2viz.ui.picture import Picture

WHILE_PLAYING = 2_000
"""So many options at most while an episode plays, where the active schema changes all the time."""

_LATE_S = 0.5  # While it plays, the close-up changes no more often.


@dataclass(frozen=True, eq=False)
class CloseUp:
    """What is drawn of the schemas that the path and the selection are in."""

    roots: tuple[int, ...]  # The schemas.
    options: NDArray[np.int64]  # Ids, parents before their children.
    edges: NDArray[np.float32]  # [E, 2, 3] from parent to child.
    n_left_out: int  # Options of these schemas for which there was no room.


def active_in(picture: Picture, options: tuple[int, ...]) -> tuple[int, ...]:
    """The schemas of these options, in order; empty if everything is drawn in full anyway."""
    if picture.detail is Detail.FULL:
        return ()
    standing = [i for i in options if 0 <= i < len(picture.stands) and picture.stands[i]]
    return tuple(sorted({int(picture.schemas[i]) for i in standing}))


def find_close_up(picture: Picture, roots: tuple[int, ...], most: int = MOST_SHAPES) -> CloseUp:
    """Up to `most` options of these schemas: those nearest to their root, the busy ones first."""
    of_these = np.isin(picture.schemas, np.array(roots, np.int64)) & (picture.sizes > 0)
    options = np.flatnonzero(of_these)
    depths = picture.depths[options]
    order = np.lexsort((options, -picture.sizes[options], depths))
    chosen = options[order[:most]]
    children = chosen[picture.parents[chosen] != NO_OPTION]
    both = [picture.positions[picture.parents[children]], picture.positions[children]]
    return CloseUp(roots, chosen, np.stack(both, axis=1), len(options) - len(chosen))


class Focus:
    """The close-up of one browser; the same object for as long as it shows the same."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._key: tuple[Picture | None, tuple[int, ...], int] = (None, (), 0)
        self._known: CloseUp | None = None
        self._since = 0.0

    def get(
        self, picture: Picture | None, options: tuple[int, ...], *, is_moving: bool
    ) -> CloseUp | None:
        """The close-up of the schemas of these options; None if none is needed.

        While things move it follows a little late, and holds fewer options.
        """
        roots = active_in(picture, options) if picture is not None else ()
        if picture is None or not roots:
            self._key, self._known = (None, (), 0), None
            return None
        key = (picture, roots, WHILE_PLAYING if is_moving else MOST_SHAPES)
        if key == self._key:
            return self._known
        now = self._clock()
        if is_moving and self._key[0] is picture and now - self._since < _LATE_S:
            return self._known
        self._key, self._since = key, now
        self._known = find_close_up(*key)
        return self._known
