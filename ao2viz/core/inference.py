"""Who speaks and how loudly: the shares of the most similar options, and the decision they make."""

from typing import NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns, distance
from ao2viz.core.compiled import compiled
from ao2viz.core.decision import NO_OPTION, DecideBy, Decision
from ao2viz.core.forest import Forest
from ao2viz.core.local_linear import (
    Workspace,
    broad_closeness,
    fit_planes,
    sharp_closeness,
    solve_local_linear,
)
from ao2viz.core.search import ANY_ACTION, find_nearest

# A plane through what D features tell has D + 1 coefficients; it is fitted to so many options for
# each of them. Imagining asks the nearest few, deciding more: many even out each one's error.
_TO_IMAGINE = 2
_TO_DECIDE = 3
# Of a kernel, in scaled distance, where all that is known lies in one place.
_NARROWEST = 1e-9


@compiled
def _find(columns: Columns, query: NDArray[np.float64], wanted: int, work: Workspace) -> int:
    """Puts the most similar options into the work space, the closest first; returns how many."""
    return find_nearest(
        columns.places,
        columns.visits,
        query,
        ANY_ACTION,
        np.inf,
        np.inf,
        work.ids[:wanted],
        work.distances[:wanted],
    )


@compiled
def _gather(
    columns: Columns,
    query: NDArray[np.float64],
    breadth: int,
    is_sharp: bool,
    work: Workspace,
) -> tuple[int, float]:
    """Finds the options that a plane at the query is fitted to, and weighs them by closeness.

    There are `breadth` for each coefficient, so the kernel is narrow where options are dense and
    wide where they are sparse (a nearest-neighbour bandwidth, as in Cleveland, 1979). Fills
    `kernel` and `offsets`; returns how many options and the kernel's width.
    """
    wanted = min(work.ids.shape[0], breadth * (query.shape[0] + 1) + 1)
    count = _find(columns, query, wanted, work)
    if count == 0:
        return 0, 0.0
    # The last one marks the width, unless all are equally near: none would have a say.
    width = max(work.distances[count - 1], 1.5 * work.distances[0], _NARROWEST)
    for n in range(count):
        d = work.distances[n]
        work.kernel[n] = sharp_closeness(d, width) if is_sharp else broad_closeness(d, width)
        for k in range(query.shape[0]):
            work.offsets[n, k] = (columns.scaled[work.ids[n], k] - query[k]) / width
    return count, width


@compiled
def find_shares(
    columns: Columns,
    query: NDArray[np.float64],
    ridge: float,
    is_deciding: bool,
    work: Workspace,
) -> int:
    """Writes the most similar options and their shares (at least 0, sum 1); returns how many."""
    breadth = _TO_DECIDE if is_deciding else _TO_IMAGINE
    count, _ = _gather(columns, query, breadth, not is_deciding, work)
    if count == 0:
        return 0
    solve_local_linear(work, count, ridge)
    total = 0.0
    for n in range(count):
        work.shares[n] = max(work.shares[n], 0.0)
        total += work.shares[n]
    for n in range(count):
        work.shares[n] /= total
    return count


@compiled
def weigh_by_vote(
    columns: Columns,
    query: NDArray[np.float64],
    ridge: float,
    work: Workspace,
    action_values: NDArray[np.float64],
) -> int:
    """Writes what each action is expected to earn by vote; returns how many options spoke.

    The options and their shares stay in the work space, the closest first.
    """
    count = find_shares(columns, query, ridge, True, work)
    work.slopes[:] = 0.0
    for a in range(action_values.shape[0]):
        total = 0.0
        for n in range(count):
            if work.shares[n] > 0.0:
                total += work.shares[n] * columns.weights[work.ids[n], a]
        action_values[a] = total
    return count


@compiled
def weigh_by_path(
    columns: Columns,
    query: NDArray[np.float64],
    has_outlook: bool,
    ridge: float,
    work: Workspace,
    action_values: NDArray[np.float64],
) -> int:
    """Writes what each action is expected to earn by the single most similar option.

    With an outlook that is the plane fitted around the option, followed to the query; else its
    weights as they are. Returns how many options stay in the work space: that one, and the second
    nearest as the runner-up.
    """
    work.slopes[:] = 0.0
    action_values[:] = 0.0
    found = _find(columns, query, 2, work)
    if found == 0:
        return 0
    option, second = work.ids[0], work.ids[1]
    near, far = work.distances[0], work.distances[1]
    if has_outlook:
        look_around(columns, option, ridge, work, action_values)
        for a in range(action_values.shape[0]):
            for d in range(query.shape[0]):
                gap = query[d] - columns.scaled[option, d]
                action_values[a] += work.slopes[a, d] * gap
    else:
        action_values[:] = columns.weights[option]
    work.ids[0], work.ids[1] = option, second
    work.distances[0], work.distances[1] = near, far
    work.shares[0] = 1.0
    return found


@compiled
def look_around(
    columns: Columns,
    option: int,
    ridge: float,
    work: Workspace,
    levels: NDArray[np.float64],
) -> None:
    """Writes an option's outlook: for each action a plane through the weights around it.

    `levels` [A] is what the action is expected to earn at the option's value, where neighbours
    even out one another's errors; `work.slopes` how that changes along each (scaled) feature.
    """
    count, width = _gather(columns, columns.scaled[option], _TO_DECIDE, False, work)
    fit_planes(columns.weights, count, width, ridge, work, levels)


@compiled
def trace_paths(
    columns: Columns,
    query: NDArray[np.float64],
    voters: NDArray[np.int64],
    paths: NDArray[np.int64],
    distances: NDArray[np.float64],
) -> None:
    """Writes each voter's path from its root, with the query's distance to every option on it."""
    for n in range(voters.shape[0]):
        option = int(voters[n])
        while option >= 0:
            paths[n, columns.depths[option]] = option
            distances[n, columns.depths[option]] = distance(columns.scaled, option, query)
            option = int(columns.parents[option])


def count_ends(voters: int, n_features: int) -> int:
    """The most options among which an imagination shares out where it ends."""
    return min(voters, _TO_IMAGINE * (n_features + 1) + 1)


def count_speakers(voters: int, n_features: int) -> int:
    """The most options that a vote or an outlook rests on; the last one only marks the width."""
    return min(voters, _TO_DECIDE * (n_features + 1) + 1)


class Reading(NamedTuple):
    """How a forest is read to decide."""

    decide_by: DecideBy
    ridge: float  # Steadies the slopes of the planes that decisions rest on.
    has_outlook: bool  # By path: follow the option's outlook; False: its weights as they are.


def choose_action(
    action_values: NDArray[np.float64], observation: NDArray[np.float64]
) -> tuple[int, bool]:
    """The action expected to earn the most, and whether several were.

    The paper settles ties at random. So that the same observation always gets the same action,
    the toss is taken from the observation's own bits, those of −0 taken for those of 0.
    """
    tied = np.flatnonzero(action_values == action_values.max())
    if len(tied) == 1:
        return int(tied[0]), False
    return int(tied[crc32((observation + 0.0).tobytes()) % len(tied)]), True


def act(forest: Forest, observation: NDArray[np.float64], reading: Reading, work: Workspace) -> int:
    """The action of `decide`, without the record of what led to it; for long evaluations."""
    action_values, _ = _weigh(forest, observation, reading, work)
    return choose_action(action_values, observation)[0]


def decide(
    forest: Forest, observation: NDArray[np.float64], reading: Reading, work: Workspace
) -> Decision:
    """The greedy decision for an observation [D], with everything that led to it.

    With an empty forest nobody speaks, every action is expected to earn 0, and it is a tie.
    """
    action_values, count = _weigh(forest, observation, reading, work)
    speaking = count if reading.decide_by is DecideBy.VOTE else min(count, 1)
    voters = work.ids[:speaking].copy()
    length = int(forest.columns.depths[voters].max()) + 1 if speaking else 0
    paths = np.full((speaking, length), NO_OPTION, np.int64)
    distances = np.full((speaking, length), np.nan)
    trace_paths(forest.columns, forest.attention * observation, voters, paths, distances)
    best, is_tie = choose_action(action_values, observation)
    return Decision(
        observation=observation,
        action=best,
        decide_by=reading.decide_by,
        action_values=action_values,
        voters=voters,
        shares=work.shares[:speaking].copy(),
        voter_weights=forest.columns.weights[voters],
        slopes=work.slopes * forest.attention,
        paths=paths,
        path_distances=distances,
        runner_up_option=int(work.ids[1]) if count > 1 else NO_OPTION,
        runner_up_distance=float(work.distances[1]) if count > 1 else np.nan,
        explored=False,
        is_tie=is_tie,
    )


def _weigh(
    forest: Forest, observation: NDArray[np.float64], reading: Reading, work: Workspace
) -> tuple[NDArray[np.float64], int]:
    """What each action is expected to earn [A], and how many options were looked at."""
    action_values = np.zeros(forest.n_actions)
    query = forest.attention * observation
    columns, ridge = forest.columns, reading.ridge
    if reading.decide_by is DecideBy.VOTE:
        return action_values, weigh_by_vote(columns, query, ridge, work, action_values)
    count = weigh_by_path(columns, query, reading.has_outlook, ridge, work, action_values)
    return action_values, count
