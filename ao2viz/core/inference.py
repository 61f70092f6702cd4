"""Who speaks and how loudly: the shares of the most similar options, and the decision they make."""

from typing import NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns, PlainColumns, distance, to_columns, to_plain
from ao2viz.core.compiled import compiled, compiled_apart
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


@compiled_apart
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


@compiled_apart
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
    # A few numbers: a list of them is faster than an array.
    values = action_values.tolist()
    most = max(values)
    if values.count(most) == 1:
        return values.index(most), False
    tied = np.flatnonzero(action_values == most)
    return int(tied[crc32((observation + 0.0).tobytes()) % len(tied)]), True


def act(forest: Forest, observation: NDArray[np.float64], reading: Reading, work: Workspace) -> int:
    """The action of `decide`, without the record of what led to it; for long evaluations."""
    action_values = _judge(*_question(forest, observation, reading, work))
    return choose_action(action_values, observation)[0]


def decide(
    forest: Forest,
    observation: NDArray[np.float64],
    reading: Reading,
    work: Workspace,
    created: int = NO_OPTION,
    drawn: int | None = None,
) -> Decision:
    """The greedy decision for an observation [D], with everything that led to it.

    With an empty forest nobody speaks, every action is expected to earn 0, and it is a tie. The
    option that was `created` for the observation goes into the record; and where exploration has
    `drawn` an action, that one is taken.
    """
    account = _account(*_question(forest, observation, reading, work), forest.attention)
    best, is_tie = choose_action(account.action_values, observation)
    return Decision(
        observation=observation,
        action=best if drawn is None else drawn,
        decide_by=reading.decide_by,
        action_values=account.action_values,
        voters=account.voters,
        shares=account.shares,
        voter_weights=account.voter_weights,
        slopes=account.slopes,
        paths=account.paths,
        path_distances=account.path_distances,
        runner_up_option=account.runner_up_option,
        runner_up_distance=account.runner_up_distance,
        explored=drawn is not None,
        is_tie=is_tie,
        created=created,
    )


_Question = tuple[PlainColumns, tuple[NDArray, ...], NDArray[np.float64], bool, bool, float]


def _question(
    forest: Forest, observation: NDArray[np.float64], reading: Reading, work: Workspace
) -> _Question:
    """What compiled code must be given to tell what to do."""
    return (
        to_plain(forest.columns),
        tuple(work),
        forest.attention * observation,
        reading.decide_by is DecideBy.VOTE,
        reading.has_outlook,
        reading.ridge,
    )


@compiled
def _judge(
    plain: PlainColumns,
    plain_work: tuple[NDArray, ...],
    query: NDArray[np.float64],
    is_vote: bool,
    has_outlook: bool,
    ridge: float,
) -> NDArray[np.float64]:
    """What each action is expected to earn [A]."""
    columns, work = to_columns(plain), Workspace(*plain_work)
    action_values = np.zeros(columns.weights.shape[1])
    _weigh(columns, work, query, is_vote, has_outlook, ridge, action_values)
    return action_values


class _Account(NamedTuple):
    """What compiled code tells of a decision; its arrays belong to nobody else."""

    action_values: NDArray[np.float64]
    voters: NDArray[np.int64]
    shares: NDArray[np.float64]
    voter_weights: NDArray[np.float64]
    slopes: NDArray[np.float64]
    paths: NDArray[np.int64]
    path_distances: NDArray[np.float64]
    runner_up_option: int
    runner_up_distance: float


@compiled
def _account(
    plain: PlainColumns,
    plain_work: tuple[NDArray, ...],
    query: NDArray[np.float64],
    is_vote: bool,
    has_outlook: bool,
    ridge: float,
    attention: NDArray[np.float64],
) -> _Account:
    """What each action is expected to earn, and who says so."""
    columns, work = to_columns(plain), Workspace(*plain_work)
    action_values = np.zeros(columns.weights.shape[1])
    count = _weigh(columns, work, query, is_vote, has_outlook, ridge, action_values)
    speaking = count if is_vote else min(count, 1)
    voters = work.ids[:speaking].copy()
    weights = np.empty((speaking, columns.weights.shape[1]))
    length = 0
    for n in range(speaking):
        weights[n] = columns.weights[voters[n]]
        length = max(length, columns.depths[voters[n]] + 1)
    paths = np.full((speaking, length), NO_OPTION, np.int64)
    distances = np.full((speaking, length), np.nan)
    trace_paths(columns, query, voters, paths, distances)
    return _Account(
        action_values,
        voters,
        work.shares[:speaking].copy(),
        weights,
        work.slopes * attention,
        paths,
        distances,
        work.ids[1] if count > 1 else NO_OPTION,
        work.distances[1] if count > 1 else np.nan,
    )


@compiled
def _weigh(
    columns: Columns,
    work: Workspace,
    query: NDArray[np.float64],
    is_vote: bool,
    has_outlook: bool,
    ridge: float,
    action_values: NDArray[np.float64],
) -> int:
    """Writes what each action is expected to earn; returns how many options were looked at."""
    if is_vote:
        return weigh_by_vote(columns, query, ridge, work, action_values)
    return weigh_by_path(columns, query, has_outlook, ridge, work, action_values)
