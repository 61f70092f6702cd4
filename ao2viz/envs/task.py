"""A Gymnasium environment as AO2 sees it: D features in, one of A primitive actions out."""

import difflib
import itertools
import math
import os
import sys
import warnings
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ao2viz.core.config import Preset
from ao2viz.envs.catalogue import CATALOGUE, Entry, Feature

# Torques of a one-dimensional action, then values per axis for two and three dimensions.
DEFAULT_ACTION_BINS = {1: 5, 2: 3, 3: 3}
MAX_ACTION_BINS = 101
_LONGEST_ID = 200
# Every option owns every action: more would be too many to learn, and to read.
MAX_ACTIONS = 1_000
# A box of features is divided into about 2**10.6, some 1,500, finest cells.
_HALVINGS = 10.6


@dataclass(frozen=True, eq=False)
class TaskSpec:
    """What an agent must know of its environment, and what a person reads about it."""

    env_id: str
    title: str
    features: tuple[Feature, ...]  # [D]
    action_names: tuple[str, ...]  # [A]
    ranges: NDArray[np.float64]  # [D] for the paper's similarity, environment units.
    action_grid: NDArray[np.float64] | None  # [A, dims] for a Box of actions, None for Discrete.
    action_offset: int  # The environment's number of the first discrete action.
    action_bins: int | None  # Values per axis of the grid, None for Discrete.
    entry: Entry

    @property
    def n_features(self) -> int:
        """D, the length of an observation."""
        return len(self.features)

    @property
    def n_actions(self) -> int:
        """A, the number of primitive actions."""
        return len(self.action_names)

    def to_env_action(self, action: int) -> Any:
        """What `env.step` wants for a primitive action's index."""
        if self.action_grid is None:
            return int(action) + self.action_offset
        return self.action_grid[action].astype(np.float32)


def make_env(env_id: str, *, render: bool = False) -> gym.Env:
    """Makes a registered environment, ready to draw pictures if asked.

    "module:EnvId" imports the module first, so that it can register the id. One that cannot draw
    is made without pictures.

    Raises:
        ValueError: If Gymnasium does not know the id or cannot make it; says what is near.
    """
    if len(env_id) > _LONGEST_ID:
        raise ValueError(
            f"Expected an environment id of at most {_LONGEST_ID} characters, "
            f"but got {len(env_id):,}."
        )
    if render:
        _draw_without_a_screen()
    try:
        with warnings.catch_warnings():
            # CartPole-v0 is in the catalogue because the paper used it; it still works.
            warnings.filterwarnings("ignore", message=".*is out of date.*")
            # One that cannot draw is found out below.
            warnings.filterwarnings("ignore", message=".*not in the possible render_modes.*")
            return gym.make(env_id, render_mode="rgb_array") if render else gym.make(env_id)
    except Exception as error:
        # Constructors may raise anything; one that knows no render_mode still trains.
        if render and env_id.rpartition(":")[2] in gym.registry:
            return make_env(env_id)
        raise ValueError(_cannot_make(env_id, error)) from error


def _cannot_make(env_id: str, error: Exception) -> str:
    near = [] if env_id in gym.registry else difflib.get_close_matches(env_id, gym.registry, n=2)
    hint = f" Did you mean {' or '.join(near)}?" if near else ""
    if isinstance(error, gym.error.DependencyNotInstalled) and "box2d" in str(error).lower():
        hint = " In short: pip install 'ao2viz[box2d]'."
    reason = str(error).strip().split("\n", maxsplit=1)[0] or type(error).__name__
    # Gymnasium guesses at names too, but not at ids that can be made.
    reason = reason.split(" Did you mean", maxsplit=1)[0].rstrip(".")
    return f"Could not make the environment {env_id!r}: {reason}.{hint}"


def _draw_without_a_screen() -> None:
    """Lets pygame draw into memory, quietly, on machines without a display or sound too."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    # Else SDL swallows SIGTERM, and a process that has drawn once can only be killed.
    os.environ.setdefault("SDL_NO_SIGNAL_HANDLERS", "1")
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
        os.environ.setdefault("SDL_AUDIODRIVER", "dummy")


def describe(env: gym.Env, action_bins: int | None = None) -> TaskSpec:
    """Reads a task off an environment, with names and settings where it is catalogued.

    Raises:
        ValueError: If its observations or actions do not fit; says what would.
    """
    env_id = env.spec.id if env.spec is not None else type(env.unwrapped).__name__
    entry = CATALOGUE.get(env_id, Entry(env_id, env_id))
    space = env.observation_space
    if not (isinstance(space, spaces.Box) and len(space.shape) == 1 and space.shape[0] > 0):
        raise ValueError(
            f"AO2 needs observations that are one row of numbers (a one-dimensional Box), but "
            f"{env_id} gives {space}. Wrap it first, for example with "
            f"gymnasium.wrappers.FlattenObservation."
        )
    n = space.shape[0]
    features = entry.features
    if len(features) != n:
        features = tuple(Feature(f"feature {i}") for i in range(n))
    names, grid, offset, bins = _actions(env, env_id, entry, action_bins)
    return TaskSpec(
        env_id=env_id,
        title=entry.title,
        features=features,
        action_names=names,
        ranges=_ranges(space, features),
        action_grid=grid,
        action_offset=offset,
        action_bins=bins,
        entry=entry,
    )


def settings_for(spec: TaskSpec, preset: Preset) -> dict[str, Any]:
    """The settings that follow from the task; of `paper` the paper's own, where we know them."""
    if preset is Preset.PAPER:
        return dict(spec.entry.paper_settings)
    return {"levels": find_levels(spec.n_features)}


def find_levels(n_features: int) -> int:
    """How often the radius halves from a root to the finest option, by the number of features.

    Each halving divides a box of D features into 2**D cells. So that the number of cells, and with
    it that of options, stays alike whatever D is, D times the levels is about constant.
    """
    return max(1, round(_HALVINGS / n_features))


def to_observation(raw: Any, spec: TaskSpec) -> NDArray[np.float64]:
    """Checks an observation and gives it as a float64 array of shape [D].

    Raises:
        ValueError: If it is not numbers, has another shape or is not finite.
    """
    try:
        observation = np.array(raw, np.float64)  # A copy: some environments reuse theirs.
    except (TypeError, ValueError):
        raise ValueError(
            f"Expected an observation of {spec.n_features} numbers from {spec.env_id}, but got "
            f"{type(raw).__name__}."
        ) from None
    if observation.shape != (spec.n_features,):
        raise ValueError(
            f"Expected an observation of shape ({spec.n_features},), one number per feature of "
            f"{spec.env_id}, but it had shape {observation.shape}."
        )
    # Asked of a few numbers at every step, and faster of each than of an array.
    if not all(map(math.isfinite, observation.tolist())):
        bad = np.flatnonzero(~np.isfinite(observation))
        told = ", ".join(f"{spec.features[i].name} = {observation[i]}" for i in bad)
        raise ValueError(f"Expected finite observations, but {spec.env_id} gave {told}.")
    return observation


def _actions(
    env: gym.Env, env_id: str, entry: Entry, action_bins: int | None
) -> tuple[tuple[str, ...], NDArray[np.float64] | None, int, int | None]:
    space = env.action_space
    if isinstance(space, spaces.Discrete):
        if action_bins is not None:
            raise ValueError(f"action_bins is for continuous actions; {env_id} has {space}.")
        if space.n > MAX_ACTIONS:
            raise ValueError(
                f"Expected at most {MAX_ACTIONS:,} actions, but {env_id} has {space.n:,}. Wrap it "
                f"so that it offers fewer."
            )
        names = entry.actions
        if len(names) != space.n:
            names = tuple(f"action {i}" for i in range(int(space.n)))
        return names, None, int(space.start), None
    if not (
        isinstance(space, spaces.Box)
        and len(space.shape) == 1
        and 1 <= space.shape[0] <= 3
        and np.isfinite(space.low).all()
        and np.isfinite(space.high).all()
    ):
        raise ValueError(
            f"AO2 needs a finite set of actions (Discrete) or a bounded Box of one to three "
            f"dimensions, but {env_id} has {space}. Wrap the environment so that it offers one."
        )
    dims = space.shape[0]
    bins = DEFAULT_ACTION_BINS[dims] if action_bins is None else action_bins
    if isinstance(bins, bool) or not isinstance(bins, int) or not 2 <= bins <= MAX_ACTION_BINS:
        raise ValueError(f"Expected action_bins from 2 to {MAX_ACTION_BINS}, but got {bins!r}.")
    if bins**dims > MAX_ACTIONS:
        raise ValueError(
            f"Expected at most {MAX_ACTIONS:,} actions, but {bins} values on each of {dims} axes "
            f"are {bins**dims:,}. Choose fewer action_bins."
        )
    axes = [np.linspace(low, high, bins) for low, high in zip(space.low, space.high, strict=True)]
    grid = np.array(list(itertools.product(*axes)), np.float64)
    word = "torque" if env_id.startswith("Pendulum") else "action"
    names = tuple(
        f"{word} " + ", ".join(f"{x:+.3g}".replace("-", "−") if x else "0" for x in row)
        for row in grid
    )
    return names, grid, 0, bins


def _ranges(space: spaces.Box, features: tuple[Feature, ...]) -> NDArray[np.float64]:
    """Width of each feature: the catalogue's, else the space's, else 1 where it is unbounded."""
    width = space.high.astype(np.float64) - space.low.astype(np.float64)
    width = np.where(np.isfinite(width) & (width > 0) & (width < 1e6), width, 1.0)
    return np.array(
        [f.range if f.range is not None else w for f, w in zip(features, width, strict=True)]
    )
