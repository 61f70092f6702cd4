"""One step of learning as one piece of compiled code: what happened, where it led, what it means.

Handing over the arrays of a whole life takes longer than many a thing that is done with them. So
it is done once a step, and as plain tuples (see `to_plain`).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.accommodation import MAX_LINKS, find_parent
from ao2viz.core.assimilation import Trace, assimilate, imagine_all, keep_stories, lengthen
from ao2viz.core.columns import Columns, add_row, to_columns, to_plain
from ao2viz.core.compiled import compiled, compiled_apart
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.experience import Experience, record
from ao2viz.core.imagination import Imagination, Rules
from ao2viz.core.law import Law
from ao2viz.core.local_linear import Workspace
from ao2viz.core.search import ANY_ACTION, find_nearest


class Life(NamedTuple):
    """All that one step of learning reads and writes."""

    columns: Columns
    heads: NDArray[np.int64]  # Of the forest: first root, number of rows in use.
    experience: Experience
    imagination: Imagination
    trace: Trace
    cursors: NDArray[np.int64]  # [2] where `assimilate` is on its rounds.
    links: NDArray[np.int64]  # [MAX_LINKS] the extra parents of the option made last.
    rules: Rules
    work: Workspace


PlainLife = tuple[Any, ...]
"""What `plain_life` makes of a life."""

Place = tuple[int, bool, int]
"""The option that stands for where one is, whether it is new, and how many extra parents it has.

NO_OPTION where the task ended; the extra parents are then in the life's `links`.
"""


def plain_life(life: Life) -> PlainLife:
    """A life as `arrive` and `live` take it."""
    return (
        to_plain(life.columns),
        life.heads,
        (*life.experience[:-1], tuple(life.experience.law)),
        tuple(life.imagination),
        tuple(life.trace),
        life.cursors,
        life.links,
        tuple(life.rules),
        tuple(life.work),
    )


def allocate_links() -> NDArray[np.int64]:
    """Room for the extra parents of one new option."""
    return np.full(MAX_LINKS, NO_OPTION, np.int64)


@compiled
def _to_life(plain: PlainLife) -> Life:
    columns, heads, experience, imagination, trace, cursors, links, rules, work = plain
    return Life(
        to_columns(columns),
        heads,
        # All but the last: five, which a type checker cannot know.
        Experience(*experience[:-1], Law(*experience[-1])),  # pyright: ignore[reportCallIssue]
        Imagination(*imagination),
        Trace(*trace),
        cursors,
        links,
        Rules(*rules),
        Workspace(*work),
    )


@compiled
def arrive(
    plain: PlainLife, observation: NDArray[np.float64], query: NDArray[np.float64], step: int
) -> Place:
    """Finds the option that stands for an observation, or accommodates it; there must be room.

    `query` is the observation scaled by attention; `step` is the agent's.
    """
    return _situate(_to_life(plain), observation, query, step)


@compiled
def live(
    plain: PlainLife,
    option: int,
    action: int,
    reward: float,
    before: NDArray[np.float64],
    observation: NDArray[np.float64],
    after: NDArray[np.float64],
    terminated: bool,
    ended: bool,
    step: int,
) -> Place:
    """Learns from one step, from `option` to the place that is returned; see `arrive`.

    Records what happened, finds where it led, and thinks. `before` and `after` are what was seen,
    scaled by attention; `observation` is the latter as the environment gave it.
    """
    life = _to_life(plain)
    columns, trace, rules = life.columns, life.trace, life.rules
    record(
        columns.visits,
        life.experience,
        option,
        action,
        before,
        after,
        reward,
        terminated,
        rules.cap,
    )
    lengthen(trace, option, action, reward)
    # A state where the task ended is no option: the chance of ending is learned instead.
    place = (NO_OPTION, False, 0)
    if not terminated:
        place = _situate(life, observation, after, step)
    keep_stories(life.imagination, trace, place[0], ended, rules)
    used = trace.used[0]
    assimilate(
        columns,
        life.experience,
        life.imagination,
        life.heads,
        option,
        action,
        trace.options[max(used - rules.trace_length, 0) : used],
        life.cursors,
        rules,
        life.work,
    )
    return place


@compiled_apart
def _situate(
    life: Life, observation: NDArray[np.float64], query: NDArray[np.float64], step: int
) -> Place:
    columns, rules, work = life.columns, life.rules, life.work
    found = find_nearest(
        columns.places,
        columns.visits,
        query,
        ANY_ACTION,
        rules.radius,
        np.inf,
        work.ids[:1],
        work.distances[:1],
    )
    if found > 0:
        return work.ids[0], False, 0
    parent, covering = find_parent(
        columns.scaled,
        columns.first_child,
        columns.next_sibling,
        life.heads[0],
        query,
        rules.levels,
        life.links,
    )
    option = add_row(columns, life.heads, observation, query, parent, step)
    imagine_all(columns, life.experience, life.imagination, option, rules, work)
    return option, True, covering
