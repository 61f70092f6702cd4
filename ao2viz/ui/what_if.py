"""What a person supposes instead of what was seen; pure."""

from collections.abc import Callable
from dataclasses import replace
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import ranges_by_id
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.nearest import NearestFlip, find_nearest_flip
from ao2viz.store.saved import Learned
from ao2viz.ui.downloads import Notify
from ao2viz.ui.jobs import Begin
from ao2viz.ui.questions import (
    FindNearest,
    StopSupposing,
    Suppose,
    SupposeState,
    Task,
    WhatIfCommand,
)
from ao2viz.ui.session import Session, Supposition
from ao2viz.ui.watched import learned_of, observation_of, spec_of
from ao2viz.ui.world import World

NEAREST_TIME_S = 30.0
"""The nearest flip of all features is searched for so long at the most."""

_HELD = "A what-if asks what was learned: hold the run, or watch a saved agent."


def state_of(
    supposition: Supposition | None, observation: NDArray[np.float64] | None
) -> NDArray[np.float64] | None:
    """What is supposed [D] at a moment; None where the supposition began from another one."""
    if supposition is None or observation is None:
        return None
    if supposition.seen != tuple(observation.tolist()):
        return None
    return np.array(supposition.state)


def suppose(
    session: Session, command: WhatIfCommand, world: World
) -> tuple[Session, tuple[Notify | Begin, ...]]:
    """The session after a command, and what has to happen outside of it."""
    observation = observation_of(session, world)
    learned, spec = learned_of(session, world), spec_of(session, world)
    if observation is None or learned is None or spec is None:
        return session, (Notify("Not here", _HELD),)
    state = state_of(session.supposition, observation)
    here = observation if state is None else state
    match command:
        case StopSupposing():
            return replace(session, supposition=None), ()
        case FindNearest():
            work = _search(learned, spec, here)
            begin = Begin(Task.NEAREST, nearest_subject(learned, here), work)
            return replace(session, is_playing=False), (begin,)
        case Suppose(feature, value):
            changed = here.tolist()
            if 0 <= feature < len(changed):
                changed[feature] = value
        case SupposeState(state):
            changed = list(state)
        case _:
            assert_never(command)
    if len(changed) != spec.n_features or not np.isfinite(changed).all():
        asked = f"Expected {spec.n_features} finite numbers, one for each feature."
        return session, (Notify("Not here", asked),)
    supposition = Supposition(tuple(observation.tolist()), tuple(changed))
    return replace(session, supposition=supposition, is_playing=False), ()


def nearest_subject(learned: Learned, state: NDArray[np.float64]) -> tuple[object, ...]:
    """What a search for the nearest flip is about."""
    return learned, state.tobytes()


def _search(
    learned: Learned, spec: TaskSpec, state: NDArray[np.float64]
) -> Callable[[Callable[[NearestFlip], bool]], NearestFlip]:
    def work(report: Callable[[NearestFlip], bool]) -> NearestFlip:
        mind = Mind(learned.config, learned.state)
        ranges = ranges_by_id(spec.env_id, spec.n_features)
        return find_nearest_flip(mind, state, ranges, NEAREST_TIME_S, report)

    return work
