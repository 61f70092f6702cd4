"""One run, in whatever process it happens: an agent learns and is evaluated along the way."""

import datetime
import functools
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.agent import AO2
from ao2viz.core.decision import DecideBy
from ao2viz.experiments.plan import Run, Schedule
from ao2viz.experiments.provenance import Provenance, provenance
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
    decide_by: DecideBy  # In these episodes; while learning, the run's settings say it.
    returns: tuple[float, ...]  # Undiscounted sum of rewards of each greedy episode.
    options: int  # Living ones in the forest.
    stack_mean: float  # Options from the root to the most similar one, over all decisions …
    stack_most: int  # … of the first STACK_EPISODES episodes.
    cpu_s: float  # Processor seconds of learning until then, the environment's steps included.
    made_by: Provenance
    finished_at: datetime.datetime  # In UTC.

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
    """Trains one agent and evaluates it at every checkpoint, in both ways of deciding.

    Evaluating never touches the agent that learns: a copy settles and plays. So the figures at a
    checkpoint are those of `AO2.learn(checkpoint)`, to the bit, whichever others there are.
    """
    agent = AO2(run.env, run.preset, run.seed, **run.overrides)
    _compile(agent.config, agent.spec.n_features, agent.spec.n_actions)
    stepper = agent.stepper()
    cpu_s = 0.0
    try:
        for checkpoint in schedule.checkpoints:
            # Of this thread: a cluster's worker does other things besides.
            started = time.thread_time()
            for _ in range(checkpoint - agent.num_timesteps):
                stepper.step()
            cpu_s += time.thread_time() - started
            yield from _evaluate(agent, run, schedule.episodes, cpu_s)
    finally:
        agent.env.close()


def _evaluate(agent: AO2, run: Run, episodes: int, cpu_s: float) -> Iterator[Evaluation]:
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
            )
    finally:
        player.env.close()


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
