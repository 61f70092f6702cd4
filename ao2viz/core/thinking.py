"""Thinking ahead: imagining sequences of actions from what is seen now, the most promising first.

Weights come from imagining as well, but from the options' values, each action repeated. Here it
begins at the observation itself, and every step may be another action. That is best-first search
on a learned model (Hart, Nilsson and Raphael, 1968, for the order).
"""

import heapq
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns
from ao2viz.core.compiled import compiled
from ao2viz.core.decision import NO_OPTION, Decision, Plan
from ao2viz.core.experience import Experience, predict
from ao2viz.core.forest import Forest
from ao2viz.core.imagination import Imagination, Rules
from ao2viz.core.inference import choose_action, find_shares
from ao2viz.core.local_linear import Workspace

MOST_IMAGINED = 20_000
"""Situations that one decision imagines at the most, however deep it is to think."""

# Situations imagined between two looks at the clock.
_AT_A_TIME = 24

Clock = Callable[[], float]
"""Seconds from some moment on; thinking with a limit of time reads it."""


def standing_clock() -> float:
    """A clock that stands still, for agents without a limit: the core itself knows no time."""
    return 0.0


class Thoughts(NamedTuple):
    """The imagined situations of one decision, `M` at the most; row 0 is what is seen.

    Every other row is reached from its parent by one action. Rows are in the order in which they
    were imagined, those past `used` are free.
    """

    states: NDArray[np.float64]  # [M, D] scaled by attention.
    parents: NDArray[np.int64]  # [M]
    firsts: NDArray[np.int64]  # [M] the action that the sequence begins with.
    actions: NDArray[np.int64]  # [M] the action that led here.
    steps: NDArray[np.int64]  # [M] from what is seen.
    rewards: NDArray[np.float64]  # [M] of the step that led here.
    continues: NDArray[np.float64]  # [M] chance that the task has not ended by then.
    earned: NDArray[np.float64]  # [M] discounted, on the whole way here.
    worths: NDArray[np.float64]  # [M] of being here, as the options around see it.
    totals: NDArray[np.float64]  # [M] earned, plus the discounted worth.
    options: NDArray[np.int64]  # [M] the most similar one.
    is_end: NDArray[np.bool_]  # [M] a sequence may end here: there is none beyond, or not every.
    is_waiting: NDArray[np.bool_]  # [M] what follows from here is not imagined yet.
    powers: NDArray[np.float64]  # [depth + 1] of gamma.
    used: NDArray[np.int64]  # [1] rows.


def begin(query: NDArray[np.float64], n_actions: int, depth: int, gamma: float) -> Thoughts:
    """Nothing imagined yet from a (scaled) observation [D]."""
    whole = 1 + sum(n_actions**steps for steps in range(1, depth + 1))
    m = min(whole, 1 + max(MOST_IMAGINED, n_actions))
    powers = np.ones(depth + 1)
    for n in range(depth):
        powers[n + 1] = powers[n] * gamma
    thoughts = Thoughts(
        states=np.empty((m, len(query))),
        parents=np.empty(m, np.int64),
        firsts=np.empty(m, np.int64),
        actions=np.empty(m, np.int64),
        steps=np.empty(m, np.int64),
        rewards=np.empty(m),
        continues=np.empty(m),
        earned=np.empty(m),
        worths=np.empty(m),
        totals=np.empty(m),
        options=np.empty(m, np.int64),
        is_end=np.zeros(m, np.bool_),
        is_waiting=np.zeros(m, np.bool_),
        powers=powers,
        used=np.ones(1, np.int64),
    )
    thoughts.states[0] = query
    thoughts.parents[0] = thoughts.firsts[0] = thoughts.actions[0] = -1
    thoughts.steps[0] = 0
    thoughts.continues[0] = 1.0
    thoughts.rewards[0] = thoughts.earned[0] = thoughts.worths[0] = thoughts.totals[0] = 0.0
    thoughts.options[0] = NO_OPTION
    thoughts.is_waiting[0] = True
    return thoughts


@compiled
def imagine_ahead(
    columns: Columns,
    experience: Experience,
    imagination: Imagination,
    thoughts: Thoughts,
    budget: int,
    rules: Rules,
    work: Workspace,
) -> bool:
    """Imagines what follows from the most promising situations; returns whether more is left.

    Goes on until at least `budget` more are imagined, or as many as there is room for. Promising
    is where most is expected in all, ties go to what was imagined first.
    """
    n_actions = columns.weights.shape[1]
    used = thoughts.used
    until = min(used[0] + budget, thoughts.parents.shape[0])
    queue = [(-thoughts.totals[n], n) for n in range(used[0]) if thoughts.is_waiting[n]]
    heapq.heapify(queue)
    while len(queue) > 0 and used[0] < until:
        if used[0] + n_actions > thoughts.parents.shape[0]:
            return False
        _, parent = heapq.heappop(queue)
        first = used[0]
        _imagine_actions(columns, experience, imagination, thoughts, parent, rules, work)
        for n in range(first, used[0]):
            if thoughts.is_waiting[n]:
                heapq.heappush(queue, (-thoughts.totals[n], n))
    return len(queue) > 0 and used[0] + n_actions <= thoughts.parents.shape[0]


@compiled
def _imagine_actions(
    columns: Columns,
    experience: Experience,
    imagination: Imagination,
    thoughts: Thoughts,
    parent: int,
    rules: Rules,
    work: Workspace,
) -> None:
    """Adds what follows each action in an imagined situation, where that is known."""
    n_actions, n_features = columns.weights.shape[1], thoughts.states.shape[1]
    state = thoughts.states[parent]
    steps = thoughts.steps[parent] + 1
    thoughts.is_waiting[parent] = False
    is_all_known = True
    for a in range(n_actions):
        if not predict(columns, experience, state, a, rules.radius, rules.effect_ridge, work):
            is_all_known = False
            continue
        n = thoughts.used[0]
        thoughts.used[0] += 1
        for d in range(n_features):
            thoughts.states[n, d] = state[d] + work.effect[d]
        reward = work.effect[n_features]
        before = thoughts.continues[parent]
        after = before * (1.0 - work.effect[n_features + 1])
        earned = thoughts.earned[parent] + thoughts.powers[steps - 1] * before * reward
        found = find_shares(columns, thoughts.states[n], rules.share_ridge, False, work)
        worth = 0.0
        if after > 0.0:
            for k in range(found):
                worth += work.shares[k] * imagination.value[work.ids[k]]
        thoughts.parents[n] = parent
        thoughts.firsts[n] = a if parent == 0 else thoughts.firsts[parent]
        thoughts.actions[n] = a
        thoughts.steps[n] = steps
        thoughts.rewards[n] = reward
        thoughts.continues[n] = after
        thoughts.earned[n] = earned
        thoughts.worths[n] = worth
        thoughts.totals[n] = earned + thoughts.powers[steps] * after * worth
        thoughts.options[n] = work.ids[0]
        thoughts.is_end[n] = True
        # Nothing follows after the end of the task.
        thoughts.is_waiting[n] = steps < thoughts.powers.shape[0] - 1 and after > 0.0
    thoughts.is_end[parent] = not is_all_known


@compiled
def find_best_ends(thoughts: Thoughts, best: NDArray[np.int64]) -> None:
    """Writes where the best sequence that begins with each action [A] ends; -1: none is known.

    Of equally good ones the one imagined first.
    """
    best[:] = -1
    for n in range(1, thoughts.used[0]):
        if not thoughts.is_end[n]:
            continue
        first = thoughts.firsts[n]
        if best[first] < 0 or thoughts.totals[n] > thoughts.totals[best[first]]:
            best[first] = n


class Horizon(NamedTuple):
    """How far one decision thinks, and when it has to come to an end."""

    steps: int  # Of the environment, at least 1.
    limit: float  # Seconds; 0: none.
    clock: Clock


def think_over(
    decision: Decision,
    forest: Forest,
    experience: Experience,
    imagination: Imagination,
    horizon: Horizon,
    rules: Rules,
    work: Workspace,
) -> Decision:
    """The decision after imagining where sequences of actions lead; itself if nothing is known.

    An action earns what the best sequence that begins with it does: the rewards on the way, each
    discounted and counted for the chance that the task goes on until then, and the worth of where
    it ends. Where an action leads is unknown, what the options say of it stands.
    """
    if len(decision.voters) == 0:
        return decision
    query = forest.attention * decision.observation
    thoughts = begin(query, forest.n_actions, horizon.steps, rules.gamma)
    mind = forest.columns, experience, imagination, thoughts
    budget = len(thoughts.parents) if horizon.limit == 0 else _AT_A_TIME
    started = horizon.clock()
    while imagine_ahead(*mind, budget, rules, work):
        if horizon.limit > 0 and horizon.clock() - started >= horizon.limit:
            break
    best = np.empty(forest.n_actions, np.int64)
    find_best_ends(thoughts, best)
    known = best >= 0
    if not known.any():
        return decision
    values = decision.action_values.copy()
    values[known] = thoughts.totals[best[known]]
    action, is_tie = choose_action(values, decision.observation)
    plan = _to_plan(thoughts, int(best[action]), decision, action, forest.attention)
    return replace(decision, action=action, action_values=values, is_tie=is_tie, plan=plan)


def _to_plan(
    thoughts: Thoughts,
    end: int,
    before: Decision,
    action: int,
    attention: NDArray[np.float64],
) -> Plan:
    """The sequence that ends at a row; one without steps if that is -1."""
    rows: list[int] = []
    row = end
    while row > 0:
        rows.insert(0, row)
        row = int(thoughts.parents[row])
    # A feature without attention has never varied: it stays as it is seen.
    states = np.tile(before.observation, (len(rows), 1))
    np.divide(thoughts.states[rows], attention, out=states, where=attention > 0)
    return Plan(
        actions=thoughts.actions[rows],
        states=states,
        rewards=thoughts.rewards[rows],
        continues=thoughts.continues[rows],
        options=thoughts.options[rows],
        worth=float(thoughts.worths[end] if rows else before.action_values[action]),
        outlook_values=before.action_values,
    )
