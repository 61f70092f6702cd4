"""Regrowing: situating every option anew after attention has changed.

The paper lets attention drift step by step ("personal impression"); here it changes seldom, and
the forest follows at once, so that what it stands for stays sound.
"""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.accommodation import MAX_LINKS, find_parent
from ao2viz.core.experience import Experience, merge
from ao2viz.core.forest import Forest
from ao2viz.core.growth import GrowthEvent, GrowthKind
from ao2viz.core.imagination import Imagination, Rules


def regrow(
    forest: Forest,
    experience: Experience,
    imagination: Imagination,
    attention: NDArray[np.float64],
    rules: Rules,
    step: int,
) -> list[GrowthEvent]:
    """Gives the forest new attention [D] and replants every option, the oldest first.

    Options that now stand for the same situation become one; their experience is merged. What was
    imagined is out of date afterwards, and there are no laws: learn them, and settle it.
    """
    events = [_rescale(forest, experience, attention, step)]
    old_parents, alive = forest.begin_regrowth()
    heirs = np.arange(forest.n_rows)
    links = np.empty(MAX_LINKS, np.int64)
    for option in alive.tolist():
        ids, distances = forest.nearest(forest.columns.values[option])
        if len(ids) and distances[0] <= rules.radius:
            heirs[option] = heir = int(ids[0])
            merge(forest.columns, experience, option, heir, rules.cap)
            events.append(forest.merge_away(option, heir, step))
            continue
        columns = forest.columns
        parent, covering = find_parent(
            columns.scaled,
            columns.first_child,
            columns.next_sibling,
            forest.heads[0],
            columns.scaled[option],
            rules.levels,
            links,
        )
        forest.replant(option, int(parent))
        if parent != old_parents[option]:
            events.append(GrowthEvent(step, GrowthKind.MOVED, option, int(parent)))
        for extra in np.sort(links[:covering]).tolist():
            events.append(forest.link(extra, option, step))
    ends = imagination.story_end[: forest.n_rows]
    ends[ends >= 0] = heirs[ends[ends >= 0]]
    return events


def _rescale(
    forest: Forest, experience: Experience, attention: NDArray[np.float64], step: int
) -> GrowthEvent:
    """Changes the attention; experience is kept in scaled units, so it follows.

    Laws do not: they are forgotten.
    """
    n, old = forest.n_rows, forest.attention
    factor = np.divide(attention, old, out=np.zeros_like(attention), where=old > 0)
    experience.displacement[:n] *= factor.astype(np.float32)
    experience.origin[:n] *= factor.astype(np.float32)
    experience.law.n_terms[:] = 0
    experience.expected[:n] = 0.0
    event = forest.set_attention(attention, step)
    # A feature that had never varied had no weight: all that was tried, was tried at its one value.
    unseen = old == 0
    experience.origin[:n, :, unseen] = forest.columns.scaled[:n, None, unseen]
    return event
