"""Cleansing: forgetting options without which the agent would decide the same.

Decided purely, then applied: a plan can be shown before anything is lost.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns, distance
from ao2viz.core.compiled import compiled
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.experience import known_within, merge
from ao2viz.core.forest import Forest
from ao2viz.core.growth import GrowthEvent
from ao2viz.core.imagination import Rules
from ao2viz.core.index import forget_option, index_option, make_index, with_room
from ao2viz.core.inference import count_speakers, look_around
from ao2viz.core.local_linear import Workspace
from ao2viz.core.memory import Memory
from ao2viz.core.search import ANY_ACTION, find_nearest


@dataclass(frozen=True, eq=False)
class CleansingPlan:
    """Which options may go, and who then stands for their situations."""

    options: NDArray[np.int64]  # [R] ids, ascending.
    heirs: NDArray[np.int64]  # [R] the most similar option that stays; it gets the experience.
    slack: float  # The most by which any action value at an option's value may change.

    def __len__(self) -> int:
        """How many options would go."""
        return len(self.options)

    def stands_for(self, n_rows: int) -> NDArray[np.int64]:
        """[N] for each option who stands for its situation afterwards: itself, or its heir."""
        options = np.arange(n_rows)
        options[self.options] = self.heirs
        return options


@dataclass(frozen=True)
class Cleansed:
    """What a cleansing has done, decisions compared before and after."""

    options_before: int
    options_after: int
    values_changed: int  # Options at whose value another action is chosen now.
    states: int  # Recorded states that were asked about.
    states_changed: int  # Those in which another action is chosen now.


def plan_cleansing(
    forest: Forest, tolerance: float, rules: Rules, work: Workspace
) -> CleansingPlan:
    """Chooses the options that the agent can do without; changes nothing.

    Seeing the value of any option, gone or not, the agent decides by path afterwards as it did:
    the best action is the same, no action is expected to earn more or less by over `tolerance`
    standard deviations of the options' greatest weights, and what was known to follow an action
    stays known. The least visited go first; heirs stay, so one plan thins out only so far.
    """
    columns, n_rows = forest.columns, forest.n_rows
    places = columns.scaled[:n_rows]
    alive = np.flatnonzero(columns.is_alive[:n_rows])
    slack = tolerance * float(columns.weights[alive].max(axis=1).std()) if len(alive) else 0.0
    is_kept = np.zeros(n_rows, np.bool_)
    heirs = np.full(n_rows, NO_OPTION, np.int64)
    known = known_within(rules.radius, forest.n_features)
    # An heir, or who last knows of an action, may be half as far away, so that what is known
    # through an option that goes is still known through its heir.
    near = known / 2
    # An index to take options out of: that of the forest stays as it is.
    thinned = columns._replace(places=with_room(make_index(places, alive)))
    _keep_witnesses(thinned, alive, near, known, work, is_kept)
    _choose(
        thinned,
        alive,
        np.argsort(columns.visits[alive].sum(axis=1), kind="stable"),  # Of equals the oldest.
        count_speakers(len(work.ids), forest.n_features),
        slack,
        near,
        rules.share_ridge,
        work,
        is_kept,
        heirs,
    )
    options = np.flatnonzero(heirs != NO_OPTION)
    return CleansingPlan(options, heirs[options], slack)


def apply_cleansing(memory: Memory, plan: CleansingPlan, cap: int, step: int) -> list[GrowthEvent]:
    """Lets the options of a plan go, and their heirs have their experience.

    What was imagined is out of date afterwards; the weights are not.
    """
    forest, experience, imagination = memory
    for option, heir in zip(plan.options.tolist(), plan.heirs.tolist(), strict=True):
        merge(forest.columns, experience, option, heir, cap)
    stands_for = plan.stands_for(forest.n_rows)
    ends = imagination.story_end[: forest.n_rows]
    ends[ends >= 0] = stands_for[ends[ends >= 0]]
    return forest.remove_all(plan.options, plan.heirs, step)


@compiled
def _keep_witnesses(
    columns: Columns,
    options: NDArray[np.int64],
    near: float,
    reach: float,
    work: Workspace,
    is_kept: NDArray[np.bool_],
) -> None:
    """Marks who alone knows of an action somewhere, and is too far away for an heir to do so."""
    ids, distances = work.ids[:1], work.distances[:1]
    for option in options:
        for a in range(columns.visits.shape[1]):
            if columns.visits[option, a] > 0:
                continue
            query = columns.scaled[option]
            found = find_nearest(
                columns.places, columns.visits, query, a, reach, np.inf, ids, distances
            )
            if found > 0 and distances[0] > near:
                is_kept[ids[0]] = True


@compiled
def _choose(
    columns: Columns,
    options: NDArray[np.int64],
    order: NDArray[np.int64],
    speakers: int,
    slack: float,
    near: float,
    ridge: float,
    work: Workspace,
    is_kept: NDArray[np.bool_],
    heirs: NDArray[np.int64],
) -> None:
    """Writes the heir of every option that may go, and takes it out of the index.

    An option is heard as far as the farthest of the `speakers` that an outlook rests on, so only
    those within whose hearing it lies have to be asked whether it may go.
    """
    n_options, n_actions = options.shape[0], columns.weights.shape[1]
    before, after = np.empty((n_options, n_actions)), np.empty(n_actions)
    hearing, heard = np.empty(n_options), np.empty(n_options)
    asked = np.empty(n_options, np.int64)
    staying = n_options
    decides = np.arange(heirs.shape[0])  # Who decides where an option is, or was.
    for n in range(n_options):
        _look_from(columns, options[n], options[n], ridge, work, before[n])
        hearing[n] = work.distances[min(speakers, staying) - 1]
    for candidate in order:
        option = int(options[candidate])
        if is_kept[option]:
            continue
        query = columns.scaled[option]
        forget_option(columns.places, columns.scaled, option)
        ids, distances = work.ids[:1], work.distances[:1]
        found = find_nearest(
            columns.places, columns.visits, query, ANY_ACTION, near, np.inf, ids, distances
        )
        heir = ids[0]
        may_go = found > 0
        if may_go:
            decides[option] = heir
        count = 0
        for n in range(n_options):
            if not may_go:
                break
            decider = decides[options[n]]
            if n != candidate and distance(columns.scaled, decider, query) > hearing[n]:
                continue
            _look_from(columns, decider, options[n], ridge, work, after)
            may_go = _agree(before[n], after, slack)
            asked[count] = n
            heard[count] = work.distances[min(speakers, staying - 1) - 1]
            count += 1
        if not may_go:
            decides[option] = option
            index_option(columns.places, columns.scaled, option)
            continue
        heirs[option] = heir
        is_kept[heir] = True
        staying -= 1
        hearing[asked[:count]] = heard[:count]


@compiled
def _look_from(
    columns: Columns,
    decider: int,
    place: int,
    ridge: float,
    work: Workspace,
    levels: NDArray[np.float64],
) -> None:
    """Writes what `decider` expects of each action at the value of the option `place`."""
    look_around(columns, decider, ridge, work, levels)
    for a in range(levels.shape[0]):
        for d in range(columns.scaled.shape[1]):
            gap = columns.scaled[place, d] - columns.scaled[decider, d]
            levels[a] += work.slopes[a, d] * gap


@compiled
def _agree(one: NDArray[np.float64], other: NDArray[np.float64], slack: float) -> bool:
    """Whether two outlooks lead to the same action, and no action value differs by more."""
    for a in range(one.shape[0]):
        if abs(one[a] - other[a]) > slack:
            return False
    return np.argmax(one) == np.argmax(other)
