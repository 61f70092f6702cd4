"""Compiles what learning needs, ahead of time, on a throw-away agent."""

import numpy as np

from ao2viz.core.agent import make_learner
from ao2viz.core.config import AnticipatingConfig, Config, change_config
from ao2viz.core.decision import DecideBy

_STEPS = 120


def warm_up(config: Config, n_features: int, n_actions: int) -> None:
    """Compiles, or loads from numba's cache on disk, everything an agent of this kind runs.

    Takes up to a minute the first time on a machine, then a fraction of a second. Nothing is left
    behind but compiled code; no agent and no generator but its own is touched.
    """
    rng = np.random.default_rng(0)
    if isinstance(config, AnticipatingConfig):
        # One step ahead compiles all there is to thinking.
        ahead = min(config.think_ahead, 1)
        settings = {"warmup_steps": 20, "sleep_sweeps": 2, "think_ahead": ahead}
        config = change_config(config, settings)
    learner = make_learner(config, np.ones(n_features), n_actions, rng)
    for step in range(_STEPS):
        # The world widens on the way, so that changing the attention is compiled as well.
        observation = rng.normal(size=n_features) * (1.0 if step < _STEPS // 2 else 4.0)
        if step % 10 == 0:
            learner.start(observation)
            continue
        ends = step % 10 == 9
        decision = learner.decide()
        learner.observe(decision, 1.0, observation, terminated=ends, truncated=False)
    learner.sleep()
    for decide_by in DecideBy:
        learner.change({"decide_by": decide_by})
        learner.act_at(np.zeros(n_features))
        learner.decide_at(np.zeros(n_features))
