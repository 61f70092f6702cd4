"""Imagining: repeating an action in the mind until the situation has changed, and where it ends."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.columns import Columns, distance
from ao2viz.core.compiled import compiled, compiled_apart, compiled_long
from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.experience import Experience, count_visits, predict
from ao2viz.core.inference import find_shares
from ao2viz.core.local_linear import Workspace

# An imagined repetition ends this many radii away from where it began.
_LEAVES_AT = 1.5


class Rules(NamedTuple):
    """The settings that compiled code needs, as plain numbers."""

    gamma: float
    radius: float  # Of the finest option.
    levels: int  # How deep an option may be planted.
    cap: int
    effect_ridge: float
    share_ridge: float
    imagine_limit: int
    refreshes: int
    backups: int
    slip: float
    trace_length: int
    story_length: int


def rules_of(config: AnticipatingConfig) -> Rules:
    """The settings of a config that compiled code needs."""
    return Rules(
        gamma=config.gamma,
        radius=0.5**config.levels,
        levels=min(config.levels, config.max_depth or config.levels),
        cap=config.experience_cap,
        effect_ridge=config.effect_ridge,
        share_ridge=config.share_ridge,
        imagine_limit=config.imagine_limit,
        refreshes=config.refreshes,
        backups=config.backups,
        slip=config.slip,
        trace_length=config.trace_length,
        story_length=config.story_length,
    )


class Imagination(NamedTuple):
    """Per option and action: the imagined story that its weight rests on."""

    steps: NDArray[np.int32]  # [C, A] repetitions imagined; 0: nothing is known.
    reward: NDArray[np.float64]  # [C, A] discounted sum over them.
    discount: NDArray[np.float64]  # [C, A] of what comes after: gamma^steps · chance of going on.
    end_ids: NDArray[np.int32]  # [C, A, K] options where it ends, NO_OPTION past the last.
    end_shares: NDArray[np.float32]  # [C, A, K] how much each of them has a say there.
    story_reward: NDArray[np.float64]  # [C, A] of the best real trace from here; NaN: none kept.
    story_discount: NDArray[np.float64]  # [C, A]
    story_end: NDArray[np.int64]  # [C, A] the option where that trace ended, or NO_OPTION.
    value: NDArray[np.float64]  # [C] what it is worth to be here; see `worth_of`.


def allocate_imagination(capacity: int, n_actions: int, ends: int) -> Imagination:
    """Nothing imagined yet, for a forest of this capacity."""
    return Imagination(
        steps=np.zeros((capacity, n_actions), np.int32),
        reward=np.zeros((capacity, n_actions)),
        discount=np.zeros((capacity, n_actions)),
        end_ids=np.full((capacity, n_actions, ends), NO_OPTION, np.int32),
        end_shares=np.zeros((capacity, n_actions, ends), np.float32),
        story_reward=np.full((capacity, n_actions), np.nan),
        story_discount=np.zeros((capacity, n_actions)),
        story_end=np.full((capacity, n_actions), NO_OPTION, np.int64),
        value=np.zeros(capacity),
    )


class Trail(NamedTuple):
    """Room for the first `L` repetitions of one imagined story; L may be 0."""

    states: NDArray[np.float64]  # [L, D] after each, scaled by attention.
    rewards: NDArray[np.float64]  # [L] of each, not discounted.
    endings: NDArray[np.float64]  # [L] chance that the task ends in it, if it comes to it.
    visits: NDArray[np.int64]  # [L] how often the action was tried by those it rests on.


@compiled
def allocate_trail(room: int, n_features: int) -> Trail:
    """A trail for so many repetitions."""
    return Trail(
        np.empty((room, n_features)), np.empty(room), np.empty(room), np.empty(room, np.int64)
    )


@compiled
def repeat(
    columns: Columns,
    experience: Experience,
    option: int,
    action: int,
    rules: Rules,
    work: Workspace,
    trail: Trail,
) -> tuple[int, float, float]:
    """Repeats an action from an option's value until it is left behind.

    That is an option in the sense of Sutton, Precup and Singh (1999), its length found by itself.
    Returns the repetitions, what they earn (discounted) and how much what comes after counts;
    where it ends stays in `work.state`.
    """
    n_features = columns.scaled.shape[1]
    state = work.state
    state[:] = columns.scaled[option]
    reward, discount = 0.0, 1.0
    steps = 0
    while steps < rules.imagine_limit:
        count = predict(columns, experience, state, action, rules.radius, rules.effect_ridge, work)
        if count == 0:
            break
        for d in range(n_features):
            state[d] += work.effect[d]
        if steps < trail.rewards.shape[0]:
            trail.states[steps] = state
            trail.rewards[steps] = work.effect[n_features]
            trail.endings[steps] = work.effect[n_features + 1]
            trail.visits[steps] = count_visits(columns.visits, action, count, work)
        steps += 1
        reward += discount * work.effect[n_features]
        discount *= rules.gamma * (1.0 - work.effect[n_features + 1])
        if distance(columns.scaled, option, state) > _LEAVES_AT * rules.radius:
            break
    return steps, float(reward), float(discount)


@compiled_apart
def imagine(
    columns: Columns,
    experience: Experience,
    imagination: Imagination,
    option: int,
    action: int,
    rules: Rules,
    work: Workspace,
) -> None:
    """Imagines anew what repeating an action leads to, and keeps it as the option's story."""
    nothing = allocate_trail(0, columns.scaled.shape[1])
    steps, reward, discount = repeat(columns, experience, option, action, rules, work, nothing)
    imagination.steps[option, action] = steps
    imagination.reward[option, action] = reward
    imagination.discount[option, action] = discount
    if steps == 0:
        return
    count = find_shares(columns, work.state, rules.share_ridge, False, work)
    kept = 0
    for n in range(count):
        if work.shares[n] > 0.0:
            imagination.end_ids[option, action, kept] = work.ids[n]
            imagination.end_shares[option, action, kept] = work.shares[n]
            kept += 1
    for n in range(kept, imagination.end_ids.shape[2]):
        imagination.end_ids[option, action, n] = NO_OPTION
        imagination.end_shares[option, action, n] = 0.0


@compiled
def backup(
    weights: NDArray[np.float64], imagination: Imagination, option: int, slip: float
) -> float:
    """Renews an option's weights [C, A] from its stories; returns by how much its value moved.

    A weight is what the imagined story earns plus what is expected where it ends, or what the
    best real trace earned, if that is more. Where nothing is known it is 0.
    """
    for a in range(weights.shape[1]):
        weight = 0.0
        known = imagination.steps[option, a] > 0
        if known:
            after = 0.0
            for n in range(imagination.end_ids.shape[2]):
                end = imagination.end_ids[option, a, n]
                if end < 0:
                    break
                after += imagination.end_shares[option, a, n] * imagination.value[end]
            weight = imagination.reward[option, a] + imagination.discount[option, a] * after
        story = story_value(
            imagination.story_reward[option, a],
            imagination.story_discount[option, a],
            imagination.story_end[option, a],
            imagination.value,
        )
        if not np.isnan(story) and (not known or story > weight):
            weight = story
        weights[option, a] = weight
    worth = worth_of(weights[option], slip)
    change = abs(worth - imagination.value[option])
    imagination.value[option] = worth
    return change


@compiled
def worth_of(weights: NDArray[np.float64], slip: float) -> float:
    """The value of being where these weights [A] hold: the best one's, were it not for a slip.

    With a chance of `slip` any action is taken, which is the value of an epsilon-soft policy
    (Sutton and Barto, Reinforcement Learning, 2nd edition, section 5.4). So a place from which
    one slip is fatal is worth less than a safe one, long before the danger is near.
    """
    best, total = -np.inf, 0.0
    for a in range(weights.shape[0]):
        total += weights[a]
        best = max(best, weights[a])
    return (1.0 - slip) * best + slip * total / weights.shape[0]


@compiled_long
def value_all(value: NDArray[np.float64], weights: NDArray[np.float64], slip: float) -> None:
    """Sets the value of being at each option [N], of these weights [N, A]."""
    for option in range(weights.shape[0]):
        value[option] = worth_of(weights[option], slip)


@compiled
def story_value(reward: float, discount: float, end: int, value: NDArray[np.float64]) -> float:
    """What a kept real trace is worth today; NaN if none is kept."""
    return reward + discount * value[end] if end >= 0 else reward
