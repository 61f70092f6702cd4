"""Evaluations made up for tests, and quick real ones."""

import datetime
import json

from ao2viz.core.config import Preset
from ao2viz.core.decision import DecideBy
from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.plan import Run, Way
from ao2viz.experiments.provenance import Provenance, provenance


def run(seed: int = 0, env: str = "CartPole-v1", **settings: object) -> Run:
    return Run(env, Preset.ANTICIPATING, json.dumps(settings), seed)


def evaluation(
    *returns: float,
    of: Run | None = None,
    steps: int = 1000,
    decide_by: Way = DecideBy.VOTE,
    made_by: Provenance | None = None,
) -> Evaluation:
    return Evaluation(
        run=of or run(),
        steps=steps,
        decide_by=decide_by,
        returns=returns or (1.0, 3.0),
        options=500,
        stack_mean=3.25 if isinstance(decide_by, DecideBy) else 0.0,
        stack_most=5 if isinstance(decide_by, DecideBy) else 0,
        cpu_s=1.5,
        made_by=made_by or provenance(),
        finished_at=datetime.datetime(2026, 1, 2, 3, 4, 5, 678, tzinfo=datetime.UTC),
    )


def both_ways(
    *returns: float, of: Run | None = None, steps: int = 1000
) -> tuple[Evaluation, Evaluation]:
    vote, path = (
        evaluation(*returns, of=of, steps=steps, decide_by=way)
        for way in (DecideBy.VOTE, DecideBy.PATH)
    )
    return vote, path
