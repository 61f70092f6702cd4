"""Recorded episodes as plain arrays, and back, checked."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.task import TaskSpec
from ao2viz.recording.episode import Episode, pack_decisions, unpack_decisions
from ao2viz.store.errors import AgentFileError
from ao2viz.store.manifest import EpisodeHeader

# Arrays of the decisions: type and dimensions, as in `Decision`; T steps, A actions, D features,
# K voters, P path, L plan.
# Observation and action of each decision are those of the episode and not stored again.
DECISIONS: Mapping[str, tuple[str, str]] = {
    "by_vote": ("bool", "T"),
    "action_values": ("float64", "TA"),
    "n_voters": ("int32", "T"),
    "path_length": ("int32", "T"),
    "voters": ("int32", "TK"),
    "shares": ("float64", "TK"),
    "voter_weights": ("float64", "TKA"),
    "slopes": ("float64", "TAD"),
    "paths": ("int32", "TKP"),
    "path_distances": ("float64", "TKP"),
    "runner_up_option": ("int32", "T"),
    "runner_up_distance": ("float64", "T"),
    "explored": ("bool", "T"),
    "is_tie": ("bool", "T"),
    "created": ("int32", "T"),
}
# Only where a decision of the episode thought ahead.
PLANS: Mapping[str, tuple[str, str]] = {
    "plan_length": ("int32", "T"),
    "plan_actions": ("int32", "TL"),
    "plan_states": ("float64", "TLD"),
    "plan_rewards": ("float64", "TL"),
    "plan_continues": ("float64", "TL"),
    "plan_options": ("int32", "TL"),
    "plan_worth": ("float64", "T"),
    "plan_outlook_values": ("float64", "TA"),
}
_FINITE = ("action_values", "shares", "voter_weights", "slopes")
_IDS = ("voters", "paths", "runner_up_option", "created")


def episode_to_arrays(episode: Episode, spec: TaskSpec) -> dict[str, NDArray]:
    """Every array of an episode, by its name inside the episode's folder.

    Raises:
        ValueError: If the decisions are not those of the episode.
    """
    packed = pack_decisions(episode.decisions, spec.n_features, spec.n_actions)
    if not (
        np.array_equal(packed.pop("observation"), episode.observations[:-1])
        and np.array_equal(packed.pop("action"), episode.actions)
    ):
        raise ValueError("Expected an episode's decisions to be about its own steps.")
    if all(decision.plan is None for decision in episode.decisions):
        packed = {name: array for name, array in packed.items() if name not in PLANS}
    return {
        "observations": episode.observations,
        "actions": episode.actions,
        "rewards": episode.rewards,
        **{f"decisions/{name}": array for name, array in packed.items()},
    }


def episode_from_arrays(
    header: EpisodeHeader,
    arrays: Mapping[str, NDArray],
    spec: TaskSpec,
    n_rows: int,
    action_smoothing: float,
) -> Episode:
    """The episode that `episode_to_arrays` took apart.

    Args:
        header: What the manifest says of it.
        arrays: Its arrays.
        spec: The agent's task.
        n_rows: Options ever made; no decision may name another.
        action_smoothing: The agent's setting.

    Raises:
        AgentFileError: If anything does not fit anything else.
    """
    t, d, a = header.steps, spec.n_features, spec.n_actions
    observations = _take(arrays, "observations", "float64", (t + 1, d))
    actions = _take(arrays, "actions", "int64", (t,))
    rewards = _take(arrays, "rewards", "float64", (t,))
    k, p = arrays.get("decisions/paths", np.empty((0, 0, 0))).shape[-2:]
    length = (*arrays.get("decisions/plan_actions", np.empty((0, 0))).shape, 0)[1]
    sizes = {"T": t, "A": a, "D": d, "K": k, "P": p, "L": length}
    # Options of format 1 had no outlook: their weights were taken as they are.
    arrays = {"decisions/slopes": np.zeros((t, a, d)), **arrays}
    thought = any(f"decisions/{name}" in arrays for name in PLANS)
    expected = {**DECISIONS, **PLANS} if thought else DECISIONS
    packed = {
        name: _take(arrays, f"decisions/{name}", dtype, tuple(sizes[letter] for letter in shape))
        for name, (dtype, shape) in expected.items()
    }
    if len(arrays) != len(packed) + 3:
        raise AgentFileError("Expected only the known arrays in a recorded episode.")
    _expect(np.isfinite(observations).all() and np.isfinite(rewards).all(), "finite observations")
    _expect(((actions >= 0) & (actions < a)).all(), f"actions below {a}")
    for name in _FINITE:
        _expect(np.isfinite(packed[name]).all(), f"finite {name}")
    for name in _IDS:
        _expect(((packed[name] >= -1) & (packed[name] < n_rows)).all(), f"{name} among the options")
    spoke = np.arange(k) < packed["n_voters"][:, None]
    _expect(((packed["n_voters"] >= 0) & (packed["n_voters"] <= k)).all(), f"at most {k} voters")
    _expect(
        ((packed["path_length"] >= 0) & (packed["path_length"] <= p)).all(),
        f"paths of at most {p} options",
    )
    _expect((packed["voters"][spoke] >= 0).all(), "an option for every voter")
    _expect((packed["shares"] >= 0).all(), "shares of at least 0")
    if spoke.any():
        _expect(p > 0 and (packed["paths"][spoke][:, 0] >= 0).all(), "a path for every voter")
        _expect((packed["path_length"][spoke.any(axis=1)] > 0).all(), "a path for every voter")
    if thought:
        _check_plans(packed, actions, a, n_rows)
    else:
        packed |= _no_plans(t, d, a)
    packed = {"observation": observations[:-1], "action": actions.astype(np.int32), **packed}
    return Episode(
        env_id=spec.env_id,
        seed=header.seed,
        observations=observations,
        actions=actions,
        rewards=rewards,
        decisions=unpack_decisions(packed),
        terminated=header.terminated,
        truncated=header.truncated,
        started_at=header.started_at,
        is_training=header.is_training,
        action_smoothing=action_smoothing,
    )


def _no_plans(t: int, d: int, a: int) -> dict[str, NDArray]:
    """The arrays of an episode in which nothing was thought ahead."""
    sizes = {"T": t, "A": a, "D": d, "L": 0}
    return {
        name: np.full(tuple(sizes[letter] for letter in shape), -1, dtype)
        for name, (dtype, shape) in PLANS.items()
    }


def _check_plans(
    packed: Mapping[str, NDArray], actions: NDArray[np.int64], n_actions: int, n_rows: int
) -> None:
    for name, (dtype, _) in PLANS.items():
        _expect(dtype != "float64" or np.isfinite(packed[name]).all(), f"finite {name}")
    lengths, most = packed["plan_length"], packed["plan_actions"].shape[1]
    _expect(((lengths >= -1) & (lengths <= most)).all(), f"plans of at most {most} steps")
    planned = np.arange(most) < lengths[:, None]
    for name, end in (("plan_actions", n_actions), ("plan_options", n_rows)):
        inside = packed[name][planned]
        _expect(((inside >= 0) & (inside < end)).all(), f"{name} from 0 to {end - 1}")
    begun = lengths > 0
    _expect(
        most == 0 or (packed["plan_actions"][begun, 0] == actions[begun]).all(),
        "plans that begin with the action taken",
    )
    chances = packed["plan_continues"]
    _expect(((chances >= 0) & (chances <= 1)).all(), "chances from 0 to 1")


def _take(arrays: Mapping[str, NDArray], name: str, dtype: str, shape: tuple[int, ...]) -> NDArray:
    array = arrays.get(name)
    if array is None:
        raise AgentFileError(f"Expected {name!r} in a recorded episode, but there is none.")
    if array.shape != shape or array.dtype.name != dtype:
        raise AgentFileError(
            f"Expected {name!r} of a recorded episode to be {dtype} of shape {shape}, but it is "
            f"{array.dtype.name} of shape {array.shape}."
        )
    return array


def _expect(is_so: bool | np.bool_, what: str) -> None:
    if not is_so:
        raise AgentFileError(f"Expected {what} in a recorded episode.")
