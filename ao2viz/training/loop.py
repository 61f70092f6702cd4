"""Where an agent meets its environment: the only code that resets and steps one for an agent."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import Decision
from ao2viz.core.forest import ForestView
from ao2viz.core.growth import GrowthEvent, GrowthKind
from ao2viz.core.learner import Learner
from ao2viz.envs.motion import Motion
from ao2viz.envs.task import TaskSpec, to_observation
from ao2viz.recording.cycle import Cycle, find_cycle
from ao2viz.recording.episode import Episode
from ao2viz.recording.growth_log import GrowthLog
from ao2viz.recording.history import EpisodeSummary, History

# Training resets with seeds below this, evaluation with seeds from here on, so no evaluation
# starts where an agent was trained. Both halves fit the signed 32 bits some environments expect.
FIRST_EVALUATION_SEED = 2**30
_SEEDS_PER_EVALUATION = 10_000


def training_seed(rng: np.random.Generator) -> int:
    """The seed of the next training episode, drawn from the agent's generator."""
    return int(rng.integers(FIRST_EVALUATION_SEED))


def evaluation_seed(seed: int, episode: int) -> int:
    """What evaluation `seed` resets the environment with before its n-th episode.

    Never a training seed. Evaluations with different seeds below 100,000 share no episode as
    long as they are at most 10,000 episodes long.
    """
    offset = seed * _SEEDS_PER_EVALUATION + episode
    return FIRST_EVALUATION_SEED + offset % FIRST_EVALUATION_SEED


def to_seed(seed: int) -> int:
    """An agent's seed, checked.

    Raises:
        ValueError: If it is no whole number from 0 on.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < 2**63:
        raise ValueError(f"Expected seed to be a whole number from 0 on, but got {seed!r}.")
    return int(seed)


def reset(env: gym.Env, spec: TaskSpec, seed: int) -> NDArray[np.float64]:
    """Begins an episode and gives its checked first observation.

    Raises:
        ValueError: If the observation does not fit; names feature and environment.
    """
    observation, _ = env.reset(seed=seed)
    return to_observation(observation, spec)


def step(
    env: gym.Env, spec: TaskSpec, motion: Motion, action: int
) -> tuple[NDArray[np.float64], float, bool, bool]:
    """Takes one step with a chosen action: checked observation, reward, terminated, truncated.

    Raises:
        ValueError: If observation or reward are not finite; names what and where.
    """
    raw, raw_reward, terminated, truncated, _ = env.step(motion.execute(action))
    observation = to_observation(raw, spec)
    try:
        reward = float(raw_reward)
    except (TypeError, ValueError):
        reward = np.nan
    if not math.isfinite(reward):
        raise ValueError(
            f"Expected a finite number as reward, but {spec.env_id} gave {raw_reward!r} after "
            f"{spec.action_names[action]!r}."
        )
    return observation, reward, bool(terminated), bool(truncated)


def play(
    env: gym.Env,
    spec: TaskSpec,
    act: Callable[[NDArray[np.float64]], int],
    seed: int,
    smoothing: float,
) -> float:
    """Plays one episode without recording it; gives the undiscounted sum of rewards.

    `smoothing` is the agent's setting `action_smoothing`.
    """
    motion = Motion(spec, smoothing)
    observation, total = reset(env, spec, seed), 0.0
    while True:
        observation, reward, terminated, truncated = step(env, spec, motion, act(observation))
        total += reward
        if terminated or truncated:
            return total


def play_recorded(
    env: gym.Env,
    spec: TaskSpec,
    decide: Callable[[NDArray[np.float64]], Decision],
    seed: int,
    smoothing: float,
) -> Episode:
    """Plays one greedy episode with every decision; arguments as for `play`."""
    motion = Motion(spec, smoothing)
    observations, rewards, decisions = [reset(env, spec, seed)], [], []
    terminated = truncated = False
    while not (terminated or truncated):
        decisions.append(decide(observations[-1]))
        seen, reward, terminated, truncated = step(env, spec, motion, decisions[-1].action)
        observations.append(seen)
        rewards.append(reward)
    return Episode(
        env_id=spec.env_id,
        seed=seed,
        observations=np.array(observations),
        actions=np.array([decision.action for decision in decisions], np.int64),
        rewards=np.array(rewards),
        decisions=tuple(decisions),
        terminated=terminated,
        truncated=truncated,
        action_smoothing=smoothing,
    )


@dataclass(frozen=True, eq=False)
class StepResult:
    """One step of one episode."""

    decision: Decision  # Why this action.
    observation: NDArray[np.float64]  # [D] what followed.
    reward: float
    terminated: bool  # The task itself ended (goal or failure).
    truncated: bool  # A time limit cut the episode off.
    events: tuple[GrowthEvent, ...]  # What learning changed in the forest.
    n_steps: int  # The agent's step count afterwards.

    @property
    def has_ended(self) -> bool:
        """Whether this was the last step of its episode."""
        return self.terminated or self.truncated


def cycle_of(before: ForestView, after: ForestView, result: StepResult) -> Cycle:
    """The stages of a step, by the forests before and after it."""
    return find_cycle(
        before,
        after,
        result.decision,
        result.reward,
        result.observation,
        result.events,
        result.n_steps,
        terminated=result.terminated,
        truncated=result.truncated,
    )


class Stepper:
    """Steps an agent through an environment, one episode after the other, and remembers the last.

    A new one begins with a fresh episode. After the end of an episode the next `step` resets
    first, so the finished one can still be looked at in between.
    """

    def __init__(
        self,
        env: gym.Env,
        spec: TaskSpec,
        learner: Learner,
        next_seed: Callable[[], int],
        *,
        learns: bool,
        history: History | None = None,
        growth: GrowthLog | None = None,
    ) -> None:
        """Wires an agent to its environment.

        Args:
            env: The environment.
            spec: The environment as the agent sees it.
            learner: Who decides and, if `learns`, explores and learns.
            next_seed: Gives the seed of each episode; called once before each.
            learns: False plays greedily and leaves the learner as it is.
            history: Gets a summary of every finished episode.
            growth: Gets every growth event, and a snapshot now and then.
        """
        self._env = env
        self._spec = spec
        self._learner = learner
        self._next_seed = next_seed
        self._learns = learns
        self._motion = Motion(spec, learner.config.action_smoothing)
        self._history = history
        self._growth = growth
        self._n_options = len(learner.view())
        self._last: StepResult | None = None
        self._needs_reset = True
        self._forget(seed=0)

    @property
    def last(self) -> StepResult | None:
        """The latest step, None before the first."""
        return self._last

    @property
    def episode_step(self) -> int:
        """Steps taken in the latest episode."""
        return len(self._rewards)

    @property
    def episode_reward(self) -> float:
        """Undiscounted sum of rewards of the latest episode so far."""
        return self._total

    def step(self) -> StepResult:
        """Takes one step, after a reset where one is due.

        Whatever the environment raises passes through; the step then was not learned from, and
        the next call begins a fresh episode.
        """
        events = self._reset() if self._needs_reset else ()
        if self._learns:
            self._keep_snapshot()
        # Until this step is through, any error makes the next one begin afresh.
        self._needs_reset = True
        learner = self._learner
        before = self._observations[-1]
        decision = learner.decide() if self._learns else learner.decide_at(before)
        observation, reward, terminated, truncated = step(
            self._env, self._spec, self._motion, decision.action
        )
        if self._learns:
            learned = learner.observe(decision, reward, observation, terminated, truncated)
            self._note(learned)
            events = (*events, *learned)
        result = StepResult(
            decision, observation, reward, terminated, truncated, events, learner.n_steps
        )
        self._remember(result)
        self._needs_reset = result.has_ended
        return result

    def episode(self) -> Episode | None:
        """The latest episode, finished or not; None while it has no step."""
        if self._last is None or not self._decisions:
            return None
        return Episode(
            env_id=self._spec.env_id,
            seed=self._seed,
            observations=np.array(self._observations),
            actions=np.array([d.action for d in self._decisions], np.int64),
            rewards=np.array(self._rewards),
            decisions=tuple(self._decisions),
            terminated=self._last.terminated,
            truncated=self._last.truncated,
            started_at=self._started_at,
            is_training=self._learns,
            action_smoothing=self._learner.config.action_smoothing,
        )

    def _reset(self) -> tuple[GrowthEvent, ...]:
        self._forget(self._next_seed())
        self._motion.begin()
        observation = reset(self._env, self._spec, self._seed)
        self._observations.append(observation)
        if not self._learns:
            return ()
        events = self._learner.start(observation)
        self._note(events)
        return events

    def _forget(self, seed: int) -> None:
        self._seed = seed
        self._started_at = self._learner.n_steps
        self._total = 0.0
        self._observations: list[NDArray[np.float64]] = []
        self._rewards: list[float] = []
        self._decisions: list[Decision] = []

    def _remember(self, result: StepResult) -> None:
        self._last = result
        self._observations.append(result.observation)
        self._rewards.append(result.reward)
        self._decisions.append(result.decision)
        self._total += result.reward
        if result.has_ended and self._history is not None:
            self._history.append(
                EpisodeSummary(result.n_steps, self._total, len(self._rewards), self._n_options)
            )

    def _keep_snapshot(self) -> None:
        """Before the step rather than after it, when all that belongs to the last one is done."""
        n_steps = self._learner.n_steps
        if self._growth is not None and self._growth.snapshots.is_due(n_steps):
            self._growth.snapshots.take(self._learner.view(), n_steps)

    def _note(self, events: tuple[GrowthEvent, ...]) -> None:
        for event in events:
            if event.kind is GrowthKind.CREATED:
                self._n_options += 1
            elif event.kind is GrowthKind.REMOVED:
                self._n_options -= 1
        if self._growth is not None:
            self._growth.extend(events)
