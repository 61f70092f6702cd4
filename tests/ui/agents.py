"""Saved agents made by hand, for what only shows them."""

from typing import Any

import numpy as np

from ao2viz.core.config import AnticipatingConfig
from ao2viz.store.saved import SavedAgent
from tests.forests import cartpole, small_view


def saved_agent(**changes: Any) -> SavedAgent:
    """The forest of `small_view`, with no episodes unless given."""
    view = small_view()
    state = {
        "values": view.values,
        "parents": view.parents.astype(np.int32),
        "weights": view.weights,
        "visits": view.visits.astype(np.int32),
        "born": view.born,
        "is_alive": view.is_alive,
        "links": view.links.astype(np.int32),
        "attention": view.attention,
        "revision": np.array(view.revision),
    }
    made = {
        "spec": cartpole(),
        "config": AnticipatingConfig(),
        "seed": 0,
        "n_steps": 7,
        "state": state,
        "generator": {},
        "history": np.empty((0, 4)),
        "growth": {},
        "growth_dropped": 0,
        "episodes": (),
    }
    return SavedAgent(**{**made, **changes})
