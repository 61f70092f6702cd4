"""Who speaks and how loudly: the shares of the most similar options, and the decision they make."""

from typing import NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns, distance
from ao2viz.core.compiled import compiled
from ao2viz.core.decision import NO_OPTION, DecideBy, Decision
from ao2viz.core.forest import Forest
from ao2viz.core.search import ANY_ACTION, find_nearest, kernel_width


class Workspace(NamedTuple):
    """Work space for one query with at most K options of D features; allocated once."""

    ids: NDArray[np.int64]  # [K]
    distances: NDArray[np.float64]  # [K]
    kernel: NDArray[np.float64]  # [K] closeness of each option, in [0, 1].
    offsets: NDArray[np.float64]  # [K, D] from the query, in kernel widths.
    normal: NDArray[np.float64]  # [D + 1, D + 1]
    solution: NDArray[np.float64]  # [D + 1]
    shares: NDArray[np.float64]  # [K]
    effect: NDArray[np.float64]  # [D + 2] displacement, reward, chance of ending.
    state: NDArray[np.float64]  # [D] where an imagination has got to.


def make_workspace(voters: int, n_features: int) -> Workspace:
    """Work space for so many voters in forests of so many features."""
    return Workspace(
        np.empty(voters, np.int64),
        np.empty(voters),
        np.empty(voters),
        np.empty((voters, n_features)),
        np.empty((n_features + 1, n_features + 1)),
        np.empty(n_features + 1),
        np.empty(voters),
        np.empty(n_features + 2),
        np.empty(n_features),
    )


@compiled
def sharp_closeness(d: float, width: float) -> float:
    """Weight of an option at distance d while imagining: only what is near tells what follows."""
    gap = 1.0 - d / width
    return gap * gap if gap > 0.0 else 0.0


@compiled
def broad_closeness(d: float, width: float) -> float:
    """Weight of an option at distance d while deciding: many voters even out each one's error.

    The tricube kernel of Cleveland (1979), 1 at the query and 0 at the kernel width.
    """
    gap = 1.0 - (d / width) ** 3
    return gap * gap * gap if gap > 0.0 else 0.0


@compiled
def factor_local_linear(work: Workspace, count: int, ridge: float) -> None:
    """Readies `normal` for a local linear regression around the query.

    Reads `kernel` and `offsets`; `normal` becomes the Cholesky factor (lower triangle) of the
    normal equations, with a ridge on the slopes.
    """
    d1 = work.offsets.shape[1] + 1
    a = work.normal
    total = 0.0
    for i in range(d1):
        for j in range(i + 1):
            a[i, j] = 0.0
    for n in range(count):
        k = work.kernel[n]
        if k == 0.0:
            continue
        total += k
        for i in range(1, d1):
            ki = k * work.offsets[n, i - 1]
            a[i, 0] += ki
            for j in range(1, i + 1):
                a[i, j] += ki * work.offsets[n, j - 1]
    a[0, 0] = total
    for i in range(1, d1):
        a[i, i] += ridge * total
    # The ridge keeps every pivot positive.
    for j in range(d1):
        s = a[j, j]
        for k2 in range(j):
            s -= a[j, k2] * a[j, k2]
        a[j, j] = np.sqrt(max(s, 1e-12 * total))
        for i in range(j + 1, d1):
            s = a[i, j]
            for k2 in range(j):
                s -= a[i, k2] * a[j, k2]
            a[i, j] = s / a[j, j]


@compiled
def solve_factored(work: Workspace) -> None:
    """Solves the equations readied by `factor_local_linear` for `solution`, in place."""
    a, c = work.normal, work.solution
    d1 = c.shape[0]
    for i in range(d1):
        s = c[i]
        for j in range(i):
            s -= a[i, j] * c[j]
        c[i] = s / a[i, i]
    for i in range(d1 - 1, -1, -1):
        s = c[i]
        for j in range(i + 1, d1):
            s -= a[j, i] * c[j]
        c[i] = s / a[i, i]


@compiled
def solve_local_linear(work: Workspace, count: int, ridge: float) -> None:
    """Shares whose weighted sum is the local linear (ridge) regression's value at the query.

    Reads `kernel` and `offsets`, writes `shares`, which add up to 1 but may be negative. Source:
    Hastie, Tibshirani and Friedman, The Elements of Statistical Learning, section 6.1.1
    (equivalent kernel), with a ridge on the slopes.
    """
    c = work.solution
    factor_local_linear(work, count, ridge)
    c[:] = 0.0
    c[0] = 1.0
    solve_factored(work)
    for n in range(count):
        s = c[0]
        for i in range(1, c.shape[0]):
            s += c[i] * work.offsets[n, i - 1]
        work.shares[n] = s * work.kernel[n]


@compiled
def find_shares(
    columns: Columns,
    query: NDArray[np.float64],
    radius: float,
    ridge: float,
    is_deciding: bool,
    work: Workspace,
) -> int:
    """Writes the most similar options and their shares (at least 0, sum 1); returns how many.

    A decision tells of all that were asked, also of those too far away to have a say.
    """
    heard = np.inf if is_deciding else radius
    count = find_nearest(
        columns.places, columns.visits, query, ANY_ACTION, np.inf, heard, work.ids, work.distances
    )
    if count == 0:
        return 0
    width = kernel_width(work.distances[0], radius)
    for n in range(count):
        d = work.distances[n]
        work.kernel[n] = broad_closeness(d, width) if is_deciding else sharp_closeness(d, width)
        for k in range(query.shape[0]):
            work.offsets[n, k] = (columns.scaled[work.ids[n], k] - query[k]) / width
    solve_local_linear(work, count, ridge)
    total = 0.0
    for n in range(count):
        work.shares[n] = max(work.shares[n], 0.0)
        total += work.shares[n]
    for n in range(count):
        work.shares[n] /= total
    return count


@compiled
def weigh_actions(
    columns: Columns,
    query: NDArray[np.float64],
    by_vote: bool,
    radius: float,
    ridge: float,
    work: Workspace,
    action_values: NDArray[np.float64],
) -> int:
    """Writes what each action is expected to earn; returns how many options were looked at.

    The options stay in the work space. By path the first of them has all the say, and the second
    is there as the runner-up.
    """
    count = find_shares(columns, query, radius, ridge, True, work)
    if not by_vote and count > 0:
        work.shares[0] = 1.0
        for n in range(1, count):
            work.shares[n] = 0.0
    for a in range(action_values.shape[0]):
        total = 0.0
        for n in range(count):
            if work.shares[n] > 0.0:
                total += work.shares[n] * columns.weights[work.ids[n], a]
        action_values[a] = total
    return count


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


def choose_action(
    action_values: NDArray[np.float64], observation: NDArray[np.float64]
) -> tuple[int, bool]:
    """The action expected to earn the most, and whether several were.

    The paper settles ties at random. So that the same observation always gets the same action,
    the toss is taken from the observation's own bits.
    """
    tied = np.flatnonzero(action_values == action_values.max())
    if len(tied) == 1:
        return int(tied[0]), False
    return int(tied[crc32(observation.tobytes()) % len(tied)]), True


def act(
    forest: Forest,
    observation: NDArray[np.float64],
    decide_by: DecideBy,
    radius: float,
    ridge: float,
    work: Workspace,
) -> int:
    """The action of `decide`, without the record of what led to it; for long evaluations."""
    action_values, _ = _weigh(forest, observation, decide_by, radius, ridge, work)
    return choose_action(action_values, observation)[0]


def decide(
    forest: Forest,
    observation: NDArray[np.float64],
    decide_by: DecideBy,
    radius: float,
    ridge: float,
    work: Workspace,
) -> Decision:
    """The greedy decision for an observation [D], with everything that led to it.

    With an empty forest nobody speaks, every action is expected to earn 0, and it is a tie.
    """
    action_values, count = _weigh(forest, observation, decide_by, radius, ridge, work)
    speaking = count if decide_by is DecideBy.VOTE else min(count, 1)
    voters = work.ids[:speaking].copy()
    length = int(forest.columns.depths[voters].max()) + 1 if speaking else 0
    paths = np.full((speaking, length), NO_OPTION, np.int64)
    distances = np.full((speaking, length), np.nan)
    trace_paths(forest.columns, forest.attention * observation, voters, paths, distances)
    best, is_tie = choose_action(action_values, observation)
    return Decision(
        observation=observation,
        action=best,
        decide_by=decide_by,
        action_values=action_values,
        voters=voters,
        shares=work.shares[:speaking].copy(),
        voter_weights=forest.columns.weights[voters],
        paths=paths,
        path_distances=distances,
        runner_up_option=int(work.ids[1]) if count > 1 else NO_OPTION,
        runner_up_distance=float(work.distances[1]) if count > 1 else np.nan,
        explored=False,
        is_tie=is_tie,
    )


def _weigh(
    forest: Forest,
    observation: NDArray[np.float64],
    decide_by: DecideBy,
    radius: float,
    ridge: float,
    work: Workspace,
) -> tuple[NDArray[np.float64], int]:
    """What each action is expected to earn [A], and how many options were looked at."""
    action_values = np.zeros(forest.n_actions)
    count = weigh_actions(
        forest.columns,
        forest.attention * observation,
        decide_by is DecideBy.VOTE,
        radius,
        ridge,
        work,
        action_values,
    )
    return action_values, count
