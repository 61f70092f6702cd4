"""What a run shows of itself: one frozen value, complete, the newest replaces the last."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.config import Config, Preset
from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.recording.cycle import Cycle
from ao2viz.recording.episode import Episode
from ao2viz.store.saved import Learned, SavedAgent
from ao2viz.training.states import USUAL_LEARNING, RunStatus


@dataclass(frozen=True, eq=False)
class RunUpdate:
    """The state of a run at one moment."""

    status: RunStatus = RunStatus.IDLE
    message: str = ""  # In words: what failed, what was refused, where a file was saved.
    is_error: bool = False  # Whether `message` tells of something that went wrong.
    run_id: int = 0  # Raised by every Start, so a page knows that a new forest begins.
    speed: float | None = None  # Steps a second at most; None: no limit.
    learning_share: float = USUAL_LEARNING  # Of the time; the rest is for updates like this one.
    spec: TaskSpec | None = None
    preset: Preset = Preset.ANTICIPATING
    seed: int = 0
    config: Config | None = None  # Its settings as they are now.
    n_steps: int = 0  # The agent's steps so far.
    first_step: int = 0  # Its steps when this run began (more than 0 after a resume).
    total_steps: int = 0  # Steps this run is to take.
    steps_per_s: float = 0.0
    eta_s: float | None = None  # Seconds to go, None when unknown.
    episode_reward: float = 0.0  # Of the episode under way.
    episode_step: int = 0
    history: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 4)))
    seconds: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))  # As `Stopwatch`.
    forest: ForestView | None = None
    decision: Decision | None = None  # The latest.
    frame: bytes | None = None  # JPEG of the environment after the latest step, if it draws.
    saved: SavedAgent | None = None  # The agent as it would be saved, only while nothing runs.
    episode: Episode | None = None  # Latest recorded episode, only while nothing runs.
    cycle: Cycle | None = None  # The latest single step, until the run goes on.

    @property
    def learned(self) -> Learned | None:
        """All that it has learned, only while nothing runs."""
        return None if self.saved is None else self.saved.learned

    @property
    def decide_by(self) -> DecideBy:
        """Who decides now."""
        return DecideBy.PATH if self.config is None else self.config.decide_by
