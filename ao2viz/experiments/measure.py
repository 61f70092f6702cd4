"""One run, in whatever process it happens: an agent learns and is evaluated along the way."""

import datetime
import functools
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ao2viz import baselines
from ao2viz.agent import AO2
from ao2viz.baselines.algorithm import Acting, Algorithm
from ao2viz.core.decision import DecideBy
from ao2viz.experiments.plan import Run, Schedule, Way
from ao2viz.experiments.provenance import Provenance, provenance
from ao2viz.recording.history import History
from ao2viz.training.loop import evaluation_seed, play
from ao2viz.training.warmup import warm_up

STACK_EPISODES = 10
"""Episodes whose decision stacks are counted; counting makes an episode about twice as long."""

# Once a process and configuration: it takes a moment even when everything is compiled.
_compile = functools.cache(warm_up)


@dataclass(frozen=True)
class Evaluation:
    """What one agent earned at one checkpoint, deciding in one way."""

    run: Run
    steps: int  # Learned from until then.
    decide_by: Way  # In these episodes; while learning, the run's settings say it.
    returns: tuple[float, ...]  # Undiscounted sum of rewards of each greedy episode.
    options: int  # Living ones in the forest; of a network, its parameters.
    stack_mean: float  # Options from the root to the most similar one (a network: 0), over all …
    stack_most: int  # … decisions of the first STACK_EPISODES episodes.
    cpu_s: float  # Processor seconds of learning until then, the environment's steps included.
    made_by: Provenance
    finished_at: datetime.datetime  # In UTC.
    # Of training, since the checkpoint before; only with the first way of deciding.
    episode_ends: tuple[int, ...] = ()  # Steps learned from when each episode ended.
    episode_returns: tuple[float, ...] = ()  # What each earned, explored and all.

    @property
    def mean_return(self) -> float:
        """Over the episodes."""
        return float(np.mean(self.returns))

    @property
    def standard_error(self) -> float | None:
        """Of the mean return; None for a single episode."""
        n = len(self.returns)
        return float(np.std(self.returns, ddof=1) / np.sqrt(n)) if n > 1 else None


@dataclass(frozen=True)
class Outcome:
    """What became of a run."""

    run: Run
    evaluations: tuple[Evaluation, ...]  # Empty if it failed.
    error: str = ""  # One line.


def attempt(run: Run, schedule: Schedule) -> Outcome:
    """Does a run; an error in it becomes part of the outcome."""
    try:
        return Outcome(run, tuple(measure(run, schedule)))
    except Exception as error:  # Environments may raise anything; the other runs go on.
        return Outcome(run, (), f"{type(error).__name__}: {' '.join(str(error).split())}")


def measure(run: Run, schedule: Schedule) -> Iterator[Evaluation]:
    """Trains one agent and evaluates it at every checkpoint, in both ways of deciding or acting.

    Evaluating never touches the agent that learns: a copy settles and plays. So the figures at a
    checkpoint are those of `AO2.learn(checkpoint)`, to the bit, whichever others there are.
    """
    if isinstance(run.preset, Algorithm):
        yield from _measure_baseline(run, run.preset, schedule)
        return
    agent = AO2(run.env, run.preset, run.seed, **run.overrides)
    _compile(agent.config, agent.spec.n_features, agent.spec.n_actions)
    stepper = agent.stepper()
    cpu_s, told = 0.0, 0
    try:
        for checkpoint in schedule.checkpoints:
            # Of this thread: a cluster's worker does other things besides.
            started = time.thread_time()
            for _ in range(checkpoint - agent.num_timesteps):
                stepper.step()
            cpu_s += time.thread_time() - started
            yield from _evaluate(agent, run, schedule.episodes, cpu_s, told)
            told = len(agent.history)
    finally:
        agent.env.close()


def _evaluate(agent: AO2, run: Run, episodes: int, cpu_s: float, told: int) -> Iterator[Evaluation]:
    player = AO2.from_saved(agent.to_saved(), run.env)
    started = time.thread_time()
    player.settle()
    cpu_s += time.thread_time() - started
    try:
        for decide_by in DecideBy:
            player.set_decide_by(decide_by)
            returns = player.evaluate(episodes)
            stacks = _stacks(player, min(episodes, STACK_EPISODES))
            yield Evaluation(
                run=run,
                steps=player.num_timesteps,
                decide_by=decide_by,
                returns=tuple(returns.tolist()),
                options=len(player.forest),
                stack_mean=float(stacks.mean()),
                stack_most=int(stacks.max()),
                cpu_s=cpu_s,
                made_by=provenance(),
                finished_at=datetime.datetime.now(datetime.UTC),
                **_training(agent.history, told, decide_by is run.ways[0]),
            )
    finally:
        player.env.close()


def _measure_baseline(run: Run, algorithm: Algorithm, schedule: Schedule) -> Iterator[Evaluation]:
    """The same of an algorithm that AO2 is compared with; evaluating leaves it as it is.

    Raises:
        ValueError: If a checkpoint is not the end of an update.
    """
    agent = baselines.make(algorithm, run.env, run.seed, **run.overrides)
    for checkpoint in schedule.checkpoints:
        if checkpoint % agent.steps_per_update:
            raise ValueError(
                f"{algorithm.value} can be evaluated after multiples of "
                f"{agent.steps_per_update:,} steps, but a checkpoint is {checkpoint:,}."
            )
    found: list[Evaluation] = []
    started, evaluating = time.thread_time(), 0.0
    told = 0

    def evaluate(_: object) -> None:
        nonlocal evaluating, told
        if agent.num_timesteps not in schedule.checkpoints:
            return
        began = time.thread_time()
        for acting in Acting:
            returns = agent.evaluate(schedule.episodes, deterministic=acting is Acting.GREEDY)
            found.append(
                Evaluation(
                    run=run,
                    steps=agent.num_timesteps,
                    decide_by=acting,
                    returns=tuple(returns.tolist()),
                    options=agent.n_parameters,
                    stack_mean=0.0,
                    stack_most=0,
                    cpu_s=began - started - evaluating,
                    made_by=provenance(),
                    finished_at=datetime.datetime.now(datetime.UTC),
                    **_training(agent.history, told, acting is run.ways[0]),
                )
            )
        told = len(agent.history)
        evaluating += time.thread_time() - began

    # In one go, as some algorithms plan how long they will learn.
    agent.learn(schedule.checkpoints[-1], evaluate)
    yield from found


def _training(history: History, told: int, is_first: bool) -> dict[str, Any]:
    """The training episodes that were not told yet."""
    rows = history.to_array()[told:] if is_first else []
    return {
        "episode_ends": tuple(int(row[0]) for row in rows),
        "episode_returns": tuple(float(row[1]) for row in rows),
    }


def _stacks(player: AO2, episodes: int) -> NDArray[np.int64]:
    """The length of the path behind each decision of the first evaluation episodes."""
    lengths: list[int] = []

    def act(observation: NDArray[np.float64]) -> int:
        decision = player.decide(observation)
        lengths.append(len(decision.path))
        return decision.action

    smoothing = player.config.action_smoothing
    for episode in range(episodes):
        play(player.env, player.spec, act, evaluation_seed(0, episode), smoothing)
    return np.array(lengths, np.int64)
