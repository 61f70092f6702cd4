"""Made-up learning curves."""

import numpy as np

from ao2viz.figures.behind import Behind


def behind(learner: str, rank: int, env: str = "CartPole-v1") -> Behind:
    """Two seeds that rise at the same three checkpoints."""
    returns = np.array([[10.0, 50.0, 200.0], [20.0, 70.0, 100.0]])
    return Behind(env, learner, rank, np.array([100, 1000, 10_000]), (900, 901), returns)
