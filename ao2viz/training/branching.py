"""An episode played otherwise: as recorded up to a step, then a person's action, then the agent's.

Nothing of the agent changes: whoever decides is a frozen mind, and what happens is an episode of
its own.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import Decision
from ao2viz.envs.motion import Motion
from ao2viz.envs.task import TaskSpec, make_env
from ao2viz.recording.episode import Episode
from ao2viz.training.loop import reset, step

MAX_STEPS = 100_000
"""No branch goes on for longer, in case its environment never ends an episode."""


@dataclass(frozen=True)
class Takeover:
    """A person chose the action of one step."""

    step: int
    action: int


class BranchStoppedError(Exception):
    """The branch was called off."""


def play_branch(
    main: Episode,
    spec: TaskSpec,
    takeovers: Sequence[Takeover],
    decide: Callable[[NDArray[np.float64]], Decision],
    limit: int = 0,
    env_id: str | None = None,
    on_step: Callable[[int], bool | None] | None = None,
) -> Episode:
    """Plays an episode otherwise from the first of some takeovers on.

    The environment is brought there by the recording's seed and actions. The action of each
    takeover is its own; `decisions` hold what the agent decided there all the same, so at these
    steps the two may differ.

    Args:
        main: As recorded.
        spec: Its task.
        takeovers: At least one, in the order of their steps, the first within the recording.
        decide: The frozen agent; it sees an observation [D].
        limit: Steps of the agent after the last takeover; 0: to the end of the episode.
        env_id: How to make the environment, where the episode's id is not enough.
        on_step: Called with the steps taken so far; returning False calls the branch off.

    Raises:
        ValueError: If the environment cannot be made, or does not repeat the recording; or if
            the episode has ended before one of the takeovers.
        BranchStoppedError: If `on_step` called it off.
    """
    chosen = {takeover.step: takeover.action for takeover in takeovers}
    first, last = takeovers[0].step, takeovers[-1].step
    end = MAX_STEPS if limit == 0 else min(MAX_STEPS, last + 1 + limit)
    env = make_env(env_id or main.env_id)
    try:
        motion = Motion(spec, main.action_smoothing)
        observations = [reset(env, spec, main.seed)]
        actions: list[int] = []
        rewards: list[float] = []
        decisions: list[Decision] = []
        terminated = truncated = False
        while not (terminated or truncated) and len(actions) < end:
            t = len(actions)
            if on_step is not None and on_step(t) is False:
                raise BranchStoppedError("The branch was called off.")
            if t <= first:
                check_repeats(main, t, observations[-1])
            decisions.append(main.decisions[t] if t <= first else decide(observations[-1]))
            agents = int(main.actions[t]) if t < first else decisions[-1].action
            actions.append(chosen.get(t, agents))
            observation, reward, terminated, truncated = step(env, spec, motion, actions[-1])
            observations.append(observation)
            rewards.append(reward)
    finally:
        env.close()
    if len(actions) <= last:
        raise ValueError(f"The episode ended at step {len(actions)}, before step {last}.")
    return replace(
        main,
        observations=np.array(observations),
        actions=np.array(actions, np.int64),
        rewards=np.array(rewards),
        decisions=tuple(decisions),
        terminated=terminated,
        truncated=truncated,
        is_training=False,
    )


def check_repeats(episode: Episode, t: int, observation: NDArray[np.float64]) -> None:
    """Compares what an environment shows before step t with what was recorded.

    Raises:
        ValueError: If they differ by more than another machine's rounding.
    """
    if not np.allclose(observation, episode.observations[t], rtol=1e-6, atol=1e-9):
        raise ValueError(
            f"{episode.env_id} no longer repeats this recording: step {t} came out "
            f"differently. It may be another version."
        )
