"""From evaluations to statements: interquartile means with bootstrap intervals.

Seeds are what is resampled, never episodes: the episodes of one agent say nothing about how the
next one would have learned. Environments are never mixed, so every interval is within one stratum.
After Agarwal et al., *Deep Reinforcement Learning at the Edge of the Statistical Precipice* (2021).
"""

import json
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.plan import Learner, Way

CONFIDENCE = 0.95
RESAMPLES = 9_999
_CUT = 0.25  # From either end; what is left is the interquartile mean.


@dataclass(frozen=True)
class Summary:
    """Every seed of one environment, preset and settings, at one checkpoint, deciding one way."""

    env: str
    preset: Learner
    settings: str  # A JSON object.
    steps: int
    decide_by: Way
    evaluations: tuple[Evaluation, ...]  # One a seed, rising.
    iqm: float  # Of the seeds' mean returns.
    interval: tuple[float, float] | None  # 95 % of the IQM; None for a single seed.

    @property
    def means(self) -> NDArray[np.float64]:
        """[S] mean return of each seed."""
        return np.array([evaluation.mean_return for evaluation in self.evaluations])

    @property
    def options(self) -> float:
        """Mean over seeds."""
        return float(np.mean([evaluation.options for evaluation in self.evaluations]))

    @property
    def stack_mean(self) -> float:
        """Length of the decision stack, mean over seeds."""
        return float(np.mean([evaluation.stack_mean for evaluation in self.evaluations]))

    @property
    def stack_most(self) -> int:
        """The longest decision stack of any seed."""
        return max(evaluation.stack_most for evaluation in self.evaluations)

    @property
    def cpu_s(self) -> float:
        """Processor seconds of learning, mean over seeds."""
        return float(np.mean([evaluation.cpu_s for evaluation in self.evaluations]))


def interquartile_mean(scores: NDArray[np.float64]) -> float:
    """The mean of the middle half; of four scores and fewer than four it cuts off one, or none.

    With n scores, a quarter of n, rounded down, is cut off at either end.
    """
    return float(stats.trim_mean(scores, _CUT))


def iqm_interval(scores: NDArray[np.float64]) -> tuple[float, float] | None:
    """The 95 % percentile bootstrap interval of the interquartile mean; None below two scores.

    The same scores give the same interval. Percentiles, not BCa, which has no answer where all
    scores are equal.
    """
    if len(scores) < 2:
        return None
    found = stats.bootstrap(
        (scores,),
        lambda resampled, axis: stats.trim_mean(resampled, _CUT, axis=axis),
        n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE,
        method="percentile",
        vectorized=True,
        rng=np.random.default_rng(0),
    ).confidence_interval
    return float(found.low), float(found.high)


def summarise(evaluations: Iterable[Evaluation]) -> list[Summary]:
    """One summary for each group of seeds, in the order of names, then steps."""
    groups: dict[tuple[str, str, str, int, str], list[Evaluation]] = defaultdict(list)
    for one in evaluations:
        key = (one.run.env, one.run.preset.value, one.run.settings, one.steps, one.decide_by.value)
        groups[key].append(one)
    return [_summarise(groups[key]) for key in sorted(groups, key=_order)]


def _order(key: tuple[str, str, str, int, str]) -> tuple:
    """Sorts settings by name and value: 0.99 before 0.995, words behind numbers."""
    env, preset, settings, *rest = key
    values = [
        (name, 0, value) if isinstance(value, int | float) else (name, 1, str(value))
        for name, value in json.loads(settings).items()
    ]
    return (env, preset, values, *rest)


def _summarise(group: list[Evaluation]) -> Summary:
    group = sorted(group, key=lambda evaluation: evaluation.run.seed)
    scores = np.array([evaluation.mean_return for evaluation in group])
    first = group[0]
    return Summary(
        env=first.run.env,
        preset=first.run.preset,
        settings=first.run.settings,
        steps=first.steps,
        decide_by=first.decide_by,
        evaluations=tuple(group),
        iqm=interquartile_mean(scores),
        interval=iqm_interval(scores),
    )
