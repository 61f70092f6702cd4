"""The comparison's learning curves, for the dashboard to lay behind a run."""

from collections.abc import Sequence

import numpy as np

from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.plan import Task
from ao2viz.figures.behind import Behind
from ao2viz.paper.findings import MAIN_WAYS
from ao2viz.paper.plan import is_main
from ao2viz.paper.published import ENVS, TITLES


def learner_curves(evaluations: Sequence[Evaluation], tasks: Sequence[Task]) -> list[Behind]:
    """A curve for each task and learner, of the runs that are whole.

    AO2 decides by one path, networks greedily, as in the report's averages.
    """
    means = {
        (one.run, one.steps): one.mean_return for one in evaluations if one.decide_by in MAIN_WAYS
    }
    curves = []
    for env in ENVS:
        for rank, (learner, title) in enumerate(TITLES.items()):
            whole = [
                task
                for task in tasks
                if task.run.env == env
                and task.run.preset is learner
                and is_main(task.run)
                and all((task.run, steps) in means for steps in task.schedule.checkpoints)
            ]
            if not whole:
                continue
            whole.sort(key=lambda task: task.run.seed)
            steps = whole[0].schedule.checkpoints
            curves.append(
                Behind(
                    env=env,
                    learner=title,
                    rank=rank,
                    steps=np.array(steps, np.int64),
                    seeds=tuple(task.run.seed for task in whole),
                    returns=np.array([[means[task.run, at] for at in steps] for task in whole]),
                )
            )
    return curves
