"""What an agent file holds, in memory."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.arrays import take_array
from ao2viz.core.config import Config, Preset, preset_of
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.recording.episode import Episode
from ao2viz.recording.past import find_depths
from ao2viz.store.errors import AgentFileError

MAX_DEPTH = 10_000
"""Options from root to leaf; a deeper file would keep the search busy for ever."""

Generator = Mapping[str, str | int]
"""A PCG64 generator's state as JSON: `state` and `inc` are hexadecimal, 128 bits each."""


@dataclass(frozen=True, eq=False)
class Learned:
    """What an agent has learned at one moment: all that a `Mind` is made of."""

    config: Config
    state: Mapping[str, NDArray]  # What `Learner.set_state` takes.
    growth: Mapping[str, NDArray]  # How it came to be: columns as in `GrowthLog`.
    growth_dropped: int  # Growth events too old to be kept.


@dataclass(frozen=True, eq=False)
class SavedAgent:
    """Everything needed to show an agent, to ask it, and to go on teaching it."""

    spec: TaskSpec  # Its task, readable without the environment.
    config: Config
    seed: int
    n_steps: int  # Steps learned from.
    state: Mapping[str, NDArray]  # What `Learner.set_state` takes.
    generator: Generator
    history: NDArray[np.float64]  # [E, 4] as in `History`.
    growth: Mapping[str, NDArray]  # Columns as in `GrowthLog`, snapshots included.
    growth_dropped: int  # Growth events too old to be kept.
    episodes: tuple[Episode, ...]
    created_at: str = ""  # ISO 8601 in UTC; set when written.
    versions: Mapping[str, str] = field(default_factory=dict)  # Libraries; set when written.

    @property
    def preset(self) -> Preset:
        """Which of the two agents it is."""
        return preset_of(self.config)

    @cached_property
    def learned(self) -> Learned:
        """What it has learned, always the same object."""
        return Learned(self.config, self.state, self.growth, self.growth_dropped)

    def forest_view(self) -> ForestView:
        """Its forest, without an environment and without compiling anything.

        Raises:
            AgentFileError: If the arrays describe no forest.
        """
        return self._view

    @cached_property
    def _view(self) -> ForestView:
        try:
            return _view_of(self.state, self.spec.n_features, self.spec.n_actions)
        except ValueError as error:
            raise AgentFileError(f"The forest in this file is not sound: {error}") from error


def get_generator(rng: np.random.Generator) -> Generator:
    """The state of a generator, ready for JSON."""
    state = rng.bit_generator.state
    return {
        "bit_generator": state["bit_generator"],
        "state": hex(state["state"]["state"]),
        "inc": hex(state["state"]["inc"]),
        "has_uint32": state["has_uint32"],
        "uinteger": state["uinteger"],
    }


def set_generator(rng: np.random.Generator, generator: Generator) -> None:
    """Lets a generator go on where `get_generator` found another."""
    state: dict[str, Any] = {
        "bit_generator": generator["bit_generator"],
        "state": {name: int(str(generator[name]), 16) for name in ("state", "inc")},
        "has_uint32": generator["has_uint32"],
        "uinteger": generator["uinteger"],
    }
    rng.bit_generator.state = state


def _view_of(state: Mapping[str, NDArray], d: int, a: int) -> ForestView:
    state = dict(state)
    n = len(state["values"]) if "values" in state and state["values"].ndim else 0
    parents = take_array(state, "parents", (n,), np.int32).astype(np.int64)
    is_alive = take_array(state, "is_alive", (n,), np.bool_)
    links = take_array(state, "links", (None, 2), np.int32).astype(np.int64)
    if ((parents < NO_OPTION) | (parents >= n)).any() or ((links < 0) | (links >= n)).any():
        raise ValueError(f"expected parents and links among the {n} options.")
    if not is_alive[links].all() or len(np.unique(links, axis=0)) != len(links):
        raise ValueError("expected every link once, between living options.")
    view = ForestView(
        values=take_array(state, "values", (n, d), np.float64),
        parents=parents,
        depths=_depths(parents, is_alive),
        weights=take_array(state, "weights", (n, a), np.float64),
        visits=take_array(state, "visits", (n, a), np.int32).astype(np.int64),
        born=take_array(state, "born", (n,), np.int64),
        is_alive=is_alive,
        links=links,
        attention=take_array(state, "attention", (d,), np.float64),
        revision=int(take_array(state, "revision", (), np.int64)),
    )
    for name in ("values", "weights", "attention"):
        if not np.isfinite(getattr(view, name)).all():
            raise ValueError(f"expected finite numbers in {name!r}.")
    if (view.visits < 0).any() or (view.born < 0).any():
        raise ValueError("expected visits and birth steps of at least 0.")
    for array in vars(view).values():
        if isinstance(array, np.ndarray):
            array.flags.writeable = False
    return view


def _depths(parents: NDArray[np.int64], is_alive: NDArray[np.bool_]) -> NDArray[np.int64]:
    """How far below its root each living option is, 0 for cleansed ones.

    Raises:
        ValueError: If a parent was cleansed, or parents lead around in a circle, or so deep that
            only a file made to do harm can have it.
    """
    has_parent = is_alive & (parents != NO_OPTION)
    if not is_alive[parents[has_parent]].all():
        raise ValueError("expected every parent to be a living option.")
    with contextlib.suppress(ValueError):
        depths = find_depths(parents, is_alive)
        if depths.max(initial=0) <= MAX_DEPTH:
            return depths
    raise ValueError(
        f"expected trees at most {MAX_DEPTH:,} deep, but some are deeper or lead in a circle."
    )
