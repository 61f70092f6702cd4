"""What follows each action: running means of experience, laws, and predictions made from both."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns
from ao2viz.core.compiled import compiled, compiled_long
from ao2viz.core.law import Law, add_displacement, allocate_law, choose_terms, fit_law
from ao2viz.core.local_linear import Workspace, sharp_closeness, solve_local_linear
from ao2viz.core.search import find_nearest, kernel_width

# A prediction needs an option that tried the action no further away than this on the average of
# the features (half a standard deviation, where attention is 4 of them wide) ...
_KNOWN_GAP = 0.125
# ... but not within fewer radii than the first, for an option knows its surroundings, nor within
# more than the second: else what was never seen is taken for known before it is looked at.
_KNOWN_RADII = (2.0, 4.0)


class Experience(NamedTuple):
    """Per option and action, running means over its visits; vectors are scaled by attention.

    All but the law have a row for each option.
    """

    reward: NDArray[np.float32]  # [C, A] per step.
    displacement: NDArray[np.float32]  # [C, A, D] next observation minus observation.
    origin: NDArray[np.float32]  # [C, A, D] where the action was tried from.
    ending: NDArray[np.float32]  # [C, A] chance that the task ended (time limits do not count).
    expected: NDArray[np.float64]  # [C, A, D] displacement that the law expects from the origin.
    law: Law  # What each action does in general.


def allocate_experience(
    capacity: int, n_actions: int, n_features: int, law_degree: int = 0
) -> Experience:
    """Experience of nothing yet, for a forest of this capacity."""
    return Experience(
        reward=np.zeros((capacity, n_actions), np.float32),
        displacement=np.zeros((capacity, n_actions, n_features), np.float32),
        origin=np.zeros((capacity, n_actions, n_features), np.float32),
        ending=np.zeros((capacity, n_actions), np.float32),
        expected=np.zeros((capacity, n_actions, n_features)),
        law=allocate_law(n_actions, n_features, law_degree),
    )


@compiled
def record(
    visits: NDArray[np.int64],
    experience: Experience,
    option: int,
    action: int,
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    reward: float,
    terminated: bool,
    cap: int,
) -> None:
    """Adds one step to the running means; past `cap` of the `visits` [C, A] the oldest fade."""
    visits[option, action] += 1
    rate = np.float32(1.0 / min(visits[option, action], cap))
    experience.reward[option, action] += rate * (
        np.float32(reward) - experience.reward[option, action]
    )
    ended = np.float32(1.0) if terminated else np.float32(0.0)
    experience.ending[option, action] += rate * (ended - experience.ending[option, action])
    for d in range(before.shape[0]):
        moved = np.float32(after[d] - before[d])
        experience.displacement[option, action, d] += rate * (
            moved - experience.displacement[option, action, d]
        )
        experience.origin[option, action, d] += rate * (
            np.float32(before[d]) - experience.origin[option, action, d]
        )
    expect(experience, option, action)


@compiled
def expect(experience: Experience, option: int, action: int) -> None:
    """Renews what the law expects of an action from where an option tried it."""
    expected = experience.expected[option, action]
    expected[:] = 0.0
    origin = experience.origin[option, action].astype(np.float64)
    add_displacement(experience.law, action, origin, expected)


def learn_law(columns: Columns, experience: Experience, n_rows: int, cap: int) -> None:
    """Fits every action's law anew, to the experience of all options that tried the action.

    A visit counts as much as any other, up to `cap` of one option.
    """
    law = experience.law
    visits = np.minimum(columns.visits[:n_rows], cap) * columns.is_alive[:n_rows, None]
    n_features, room = experience.origin.shape[2], law.coefficients.shape[1]
    if room == 0 or not visits.any():
        return
    law.centre[:] = np.average(
        experience.origin[:n_rows].astype(np.float64).reshape(-1, n_features),
        axis=0,
        weights=visits.reshape(-1),
    )
    for action in range(visits.shape[1]):
        tried = np.flatnonzero(visits[:, action])
        fit_law(
            law,
            action,
            choose_terms(n_features, room, len(tried)),
            experience.origin[tried, action].astype(np.float64),
            experience.displacement[tried, action].astype(np.float64),
            visits[tried, action].astype(np.float64),
        )
    expect_all(experience, n_rows)


@compiled_long
def expect_all(experience: Experience, n_rows: int) -> None:
    """Renews what the laws expect, for every option and action."""
    for option in range(n_rows):
        for action in range(experience.expected.shape[1]):
            expect(experience, option, action)


@compiled
def merge(columns: Columns, experience: Experience, option: int, heir: int, cap: int) -> None:
    """Adds an option's experience to its heir's, each mean counting for its visits."""
    for a in range(columns.visits.shape[1]):
        new = min(columns.visits[option, a], cap)
        if new == 0:
            continue
        old = min(columns.visits[heir, a], cap)
        rate = np.float32(new / (old + new))
        columns.visits[heir, a] += columns.visits[option, a]
        experience.reward[heir, a] += rate * (
            experience.reward[option, a] - experience.reward[heir, a]
        )
        experience.ending[heir, a] += rate * (
            experience.ending[option, a] - experience.ending[heir, a]
        )
        for d in range(experience.origin.shape[2]):
            experience.displacement[heir, a, d] += rate * (
                experience.displacement[option, a, d] - experience.displacement[heir, a, d]
            )
            experience.origin[heir, a, d] += rate * (
                experience.origin[option, a, d] - experience.origin[heir, a, d]
            )
        expect(experience, heir, a)


@compiled
def known_within(radius: float, n_features: int) -> float:
    """How near an option must have tried an action for what follows it to be known.

    `radius` is that of the finest option.
    """
    least, most = _KNOWN_RADII
    return min(max(_KNOWN_GAP * n_features, least * radius), most * radius)


@compiled
def predict(
    columns: Columns,
    experience: Experience,
    state: NDArray[np.float64],
    action: int,
    radius: float,
    ridge: float,
    work: Workspace,
) -> int:
    """Writes what an action is expected to do at a (scaled) state into `work.effect`.

    A local linear regression over the most similar options that tried the action: displacement
    [D], reward, chance of ending. Of the displacement it is what the action does by its law, plus
    how it differed from the law around here. Returns how many options it rests on, the first so
    many of the work space; 0 if none of them is close enough to know.
    """
    reach = known_within(radius, state.shape[0])
    count = find_nearest(
        columns.places,
        columns.visits,
        state,
        action,
        1.5 * reach,
        radius,
        work.ids,
        work.distances,
    )
    if count == 0 or work.distances[0] > reach:
        return 0
    n_features = state.shape[0]
    width = kernel_width(work.distances[0], radius)
    for n in range(count):
        option = work.ids[n]
        work.kernel[n] = sharp_closeness(work.distances[n], width)
        for d in range(n_features):
            work.offsets[n, d] = (experience.origin[option, action, d] - state[d]) / width
    solve_local_linear(work, count, ridge)
    work.effect[:] = 0.0
    for n in range(count):
        share = work.shares[n]
        option = work.ids[n]
        for d in range(n_features):
            surprise = (
                experience.displacement[option, action, d] - experience.expected[option, action, d]
            )
            work.effect[d] += share * surprise
        work.effect[n_features] += share * experience.reward[option, action]
        work.effect[n_features + 1] += share * experience.ending[option, action]
    add_displacement(experience.law, action, state, work.effect)
    work.effect[n_features + 1] = min(max(work.effect[n_features + 1], 0.0), 1.0)
    return count


@compiled
def count_visits(visits: NDArray[np.int64], action: int, count: int, work: Workspace) -> int:
    """How often the options that the latest `predict` rests on had tried the action."""
    total = 0
    for n in range(count):
        if work.kernel[n] > 0.0:
            total += visits[work.ids[n], action]
    return total
