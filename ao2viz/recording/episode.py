"""One recorded episode: enough to replay it exactly and to explain every step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.card import make_card
from ao2viz.core.decision import DecideBy, Decision, Plan


@dataclass(frozen=True, eq=False)
class Episode:
    """Seed, actions and decisions of one episode, from reset to its last step.

    Resetting the environment with `seed` and repeating `actions`, smoothed as they were, gives it
    again, bit for bit.
    `T` counts steps; there is one decision a step and one observation more.
    """

    env_id: str
    seed: int  # What the environment was reset with.
    observations: NDArray[np.float64]  # [T + 1, D]
    actions: NDArray[np.int64]  # [T] indices of the primitive actions that were chosen.
    rewards: NDArray[np.float64]  # [T]
    decisions: tuple[Decision, ...]  # [T]
    terminated: bool  # The task itself ended (goal or failure).
    truncated: bool  # A time limit cut it off; both False: still under way.
    started_at: int = 0  # The agent's step count when the episode began.
    is_training: bool = False  # Recorded while learning (explores), not greedily.
    action_smoothing: float = 1.0  # The agent's setting: how actions became what was executed.

    def __len__(self) -> int:
        """Steps taken."""
        return len(self.actions)

    @property
    def total_reward(self) -> float:
        """Undiscounted sum of rewards, the return that people quote."""
        return float(self.rewards.sum())

    def _repr_html_(self) -> str:
        """What notebooks show."""
        ending = "still under way"
        if self.terminated:
            ending = "by the task"
        elif self.truncated:
            ending = "by the time limit"
        longest = max((len(decision.path) for decision in self.decisions), default=0)
        return make_card(
            f"Episode of {self.env_id}",
            [
                ("seed", str(self.seed)),
                ("steps", f"{len(self):,}"),
                ("return", f"{self.total_reward:.6g}"),
                ("ended", ending),
                ("recorded", "while learning" if self.is_training else "greedily"),
                ("longest path", f"{longest} options"),
            ],
            [decision.margin for decision in self.decisions],
            "margin of each decision",
        )


def pack_decisions(
    decisions: Sequence[Decision], n_features: int, n_actions: int
) -> dict[str, NDArray]:
    """Decisions as plain arrays [T, …], padded; `unpack_decisions` gives them back exactly."""
    t = len(decisions)
    k = max((len(d.voters) for d in decisions), default=0)
    p = max((d.paths.shape[1] for d in decisions), default=0)
    packed: dict[str, NDArray] = {
        "observation": np.zeros((t, n_features)),
        "action": np.zeros(t, np.int32),
        "by_vote": np.zeros(t, np.bool_),
        "action_values": np.zeros((t, n_actions)),
        "n_voters": np.zeros(t, np.int32),
        "path_length": np.zeros(t, np.int32),
        "voters": np.full((t, k), -1, np.int32),
        "shares": np.zeros((t, k)),
        "voter_weights": np.zeros((t, k, n_actions)),
        "slopes": np.zeros((t, n_actions, n_features)),
        "paths": np.full((t, k, p), -1, np.int32),
        "path_distances": np.full((t, k, p), np.nan),
        "runner_up_option": np.full(t, -1, np.int32),
        "runner_up_distance": np.full(t, np.nan),
        "explored": np.zeros(t, np.bool_),
        "is_tie": np.zeros(t, np.bool_),
        "created": np.full(t, -1, np.int32),
        **_pack_plans([d.plan for d in decisions], n_features, n_actions),
    }
    for i, d in enumerate(decisions):
        n, length = len(d.voters), d.paths.shape[1]
        packed["observation"][i] = d.observation
        packed["action"][i] = d.action
        packed["by_vote"][i] = d.decide_by is DecideBy.VOTE
        packed["action_values"][i] = d.action_values
        packed["n_voters"][i] = n
        packed["path_length"][i] = length
        packed["voters"][i, :n] = d.voters
        packed["shares"][i, :n] = d.shares
        packed["voter_weights"][i, :n] = d.voter_weights
        packed["slopes"][i] = d.slopes
        packed["paths"][i, :n, :length] = d.paths
        packed["path_distances"][i, :n, :length] = d.path_distances
        packed["runner_up_option"][i] = d.runner_up_option
        packed["runner_up_distance"][i] = d.runner_up_distance
        packed["explored"][i] = d.explored
        packed["is_tie"][i] = d.is_tie
        packed["created"][i] = d.created
    return packed


def _pack_plans(
    plans: Sequence[Plan | None], n_features: int, n_actions: int
) -> dict[str, NDArray]:
    """What each decision thought ahead, as arrays [T, …]; a length of -1: it did not."""
    t = len(plans)
    length = max((len(plan.actions) for plan in plans if plan is not None), default=0)
    packed: dict[str, NDArray] = {
        "plan_length": np.full(t, -1, np.int32),
        "plan_actions": np.full((t, length), -1, np.int32),
        "plan_states": np.zeros((t, length, n_features)),
        "plan_rewards": np.zeros((t, length)),
        "plan_continues": np.zeros((t, length)),
        "plan_options": np.full((t, length), -1, np.int32),
        "plan_worth": np.zeros(t),
        "plan_outlook_values": np.zeros((t, n_actions)),
    }
    for i, plan in enumerate(plans):
        if plan is None:
            continue
        n = len(plan.actions)
        packed["plan_length"][i] = n
        packed["plan_actions"][i, :n] = plan.actions
        packed["plan_states"][i, :n] = plan.states
        packed["plan_rewards"][i, :n] = plan.rewards
        packed["plan_continues"][i, :n] = plan.continues
        packed["plan_options"][i, :n] = plan.options
        packed["plan_worth"][i] = plan.worth
        packed["plan_outlook_values"][i] = plan.outlook_values
    return packed


def _unpack_plan(packed: dict[str, NDArray], i: int) -> Plan | None:
    n = int(packed["plan_length"][i])
    if n < 0:
        return None
    return Plan(
        actions=packed["plan_actions"][i, :n].astype(np.int64),
        states=packed["plan_states"][i, :n],
        rewards=packed["plan_rewards"][i, :n],
        continues=packed["plan_continues"][i, :n],
        options=packed["plan_options"][i, :n].astype(np.int64),
        worth=float(packed["plan_worth"][i]),
        outlook_values=packed["plan_outlook_values"][i],
    )


def unpack_decisions(packed: dict[str, NDArray]) -> tuple[Decision, ...]:
    """The decisions that `pack_decisions` packed."""
    decisions = []
    for i in range(len(packed["action"])):
        n, length = int(packed["n_voters"][i]), int(packed["path_length"][i])
        decisions.append(
            Decision(
                observation=packed["observation"][i],
                action=int(packed["action"][i]),
                decide_by=DecideBy.VOTE if packed["by_vote"][i] else DecideBy.PATH,
                action_values=packed["action_values"][i],
                voters=packed["voters"][i, :n].astype(np.int64),
                shares=packed["shares"][i, :n],
                voter_weights=packed["voter_weights"][i, :n],
                slopes=packed["slopes"][i],
                paths=packed["paths"][i, :n, :length].astype(np.int64),
                path_distances=packed["path_distances"][i, :n, :length],
                runner_up_option=int(packed["runner_up_option"][i]),
                runner_up_distance=float(packed["runner_up_distance"][i]),
                explored=bool(packed["explored"][i]),
                is_tie=bool(packed["is_tie"][i]),
                created=int(packed["created"][i]),
                plan=_unpack_plan(packed, i),
            )
        )
    return tuple(decisions)
