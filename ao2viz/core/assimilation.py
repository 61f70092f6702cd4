"""Assimilation: letting what was experienced and imagined move the weights."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns
from ao2viz.core.compiled import compiled, compiled_apart
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.experience import Experience
from ao2viz.core.imagination import Imagination, Rules, backup, imagine, story_value
from ao2viz.core.local_linear import Workspace

# A sweep that moves no value by more than this fraction of the largest ends the sleep.
_SETTLED = 1e-4


class Trace(NamedTuple):
    """The latest steps of an episode, the newest last; room for twice as many as are asked for."""

    options: NDArray[np.int64]  # [2 T]
    actions: NDArray[np.int64]  # [2 T]
    rewards: NDArray[np.float64]  # [2 T]
    used: NDArray[np.int64]  # [1] rows.


def allocate_trace(rules: Rules) -> Trace:
    """A trace of no steps yet, long enough for these rules."""
    rows = 2 * max(rules.trace_length, rules.story_length)
    return Trace(
        np.zeros(rows, np.int64), np.zeros(rows, np.int64), np.zeros(rows), np.zeros(1, np.int64)
    )


@compiled
def lengthen(trace: Trace, option: int, action: int, reward: float) -> None:
    """Adds a step to the trace; where there is no room the older half goes first."""
    row = trace.used[0]
    if row == trace.options.shape[0]:
        row //= 2
        trace.options[:row] = trace.options[row:]
        trace.actions[:row] = trace.actions[row:]
        trace.rewards[:row] = trace.rewards[row:]
    trace.options[row] = option
    trace.actions[row] = action
    trace.rewards[row] = reward
    trace.used[0] = row + 1


@compiled_apart
def imagine_all(
    columns: Columns,
    experience: Experience,
    imagination: Imagination,
    option: int,
    rules: Rules,
    work: Workspace,
) -> None:
    """Imagines every action of one option, then renews its weights."""
    for a in range(columns.weights.shape[1]):
        imagine(columns, experience, imagination, option, a, rules, work)
    backup(columns.weights, imagination, option, rules.slip)


@compiled
def assimilate(
    columns: Columns,
    experience: Experience,
    imagination: Imagination,
    heads: NDArray[np.int64],
    option: int,
    action: int,
    recent: NDArray[np.int64],
    cursors: NDArray[np.int64],
    rules: Rules,
    work: Workspace,
) -> None:
    """One step's worth of thinking: about what just happened, then a little about the rest.

    `recent` holds the latest options, the newest last; the two `cursors` walk over all (option,
    action) pairs and all options, from the newest to the oldest and round again.
    """
    n_actions = columns.weights.shape[1]
    n_rows = heads[1]
    imagine(columns, experience, imagination, option, action, rules, work)
    for n in range(recent.shape[0] - 1, -1, -1):
        backup(columns.weights, imagination, recent[n], rules.slip)
    for _ in range(rules.refreshes):
        cursors[0] -= 1
        if cursors[0] < 0 or cursors[0] >= n_rows * n_actions:
            cursors[0] = n_rows * n_actions - 1
        other = cursors[0] // n_actions
        if columns.is_alive[other]:
            imagine(
                columns,
                experience,
                imagination,
                other,
                cursors[0] % n_actions,
                rules,
                work,
            )
    for _ in range(rules.backups):
        cursors[1] -= 1
        if cursors[1] < 0 or cursors[1] >= n_rows:
            cursors[1] = n_rows - 1
        if columns.is_alive[cursors[1]]:
            backup(columns.weights, imagination, cursors[1], rules.slip)


@compiled
def settle(
    columns: Columns,
    experience: Experience,
    imagination: Imagination,
    heads: NDArray[np.int64],
    sweeps: int,
    rules: Rules,
    work: Workspace,
) -> int:
    """Imagines everything anew and backs up until the values rest; returns the sweeps taken."""
    for option in range(heads[1]):
        if columns.is_alive[option]:
            for a in range(columns.weights.shape[1]):
                imagine(columns, experience, imagination, option, a, rules, work)
    for sweep in range(sweeps):
        moved, largest = 0.0, 0.0
        for option in range(heads[1] - 1, -1, -1):
            if columns.is_alive[option]:
                moved = max(moved, backup(columns.weights, imagination, option, rules.slip))
                largest = max(largest, abs(imagination.value[option]))
        if moved <= _SETTLED * largest:
            return sweep + 1
    return sweeps


@compiled
def keep_stories(
    imagination: Imagination, trace: Trace, end: int, has_ended: bool, rules: Rules
) -> None:
    """Keeps the real trace that left each (option, action) if it beats the one kept so far.

    Real traces are of `story_length` steps and lead to option `end` (NO_OPTION: the task ended
    there); when the episode has ended, every shorter one that ends there counts as well.
    """
    last, length = trace.used[0], rules.story_length
    if length == 0 or (last < length and not has_ended):
        return
    first = max(last - length, 0)
    reward, discount = 0.0, 1.0
    for n in range(last - 1, first - 1, -1):
        reward = trace.rewards[n] + rules.gamma * reward
        discount *= rules.gamma
        if n > first and not has_ended:
            continue
        worth = reward
        if end >= 0:
            worth += discount * imagination.value[end]
        option, action = int(trace.options[n]), int(trace.actions[n])
        kept = story_value(
            imagination.story_reward[option, action],
            imagination.story_discount[option, action],
            int(imagination.story_end[option, action]),
            imagination.value,
        )
        if np.isnan(kept) or worth > kept:
            imagination.story_reward[option, action] = reward
            imagination.story_discount[option, action] = 0.0 if end < 0 else discount
            imagination.story_end[option, action] = end if end >= 0 else NO_OPTION
