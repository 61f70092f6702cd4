"""One place that knows which learner belongs to which preset."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.anticipating import AnticipatingLearner
from ao2viz.core.config import AnticipatingConfig, Config
from ao2viz.core.learner import Learner
from ao2viz.core.paper import PaperLearner
from ao2viz.core.thinking import Clock, standing_clock


def make_learner(
    config: Config,
    ranges: NDArray[np.float64],
    n_actions: int,
    rng: np.random.Generator,
    clock: Clock = standing_clock,
) -> Learner:
    """A learner that knows nothing yet.

    `ranges` [D] are the features' widths in environment units, for the paper's similarity. The
    generator is the caller's; the learner draws exploration (and the `paper` preset ties) from it.
    `think_limit` holds by the clock given: without one, an agent thinks for as long as it takes.
    """
    if isinstance(config, AnticipatingConfig):
        return AnticipatingLearner(config, ranges, n_actions, rng, clock)
    return PaperLearner(config, ranges, n_actions, rng)
