"""From the action that was chosen to what the environment executes: at once, or smoothed."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.task import TaskSpec


class Motion:
    """Turns the actions chosen in one episode after the other into what `env.step` wants.

    With a smoothing s below 1 what is executed is s · chosen + (1 - s) · what was executed last
    (Hakimzadeh et al., "Smooth actions"); the first action of an episode as it is.
    """

    def __init__(self, spec: TaskSpec, smoothing: float) -> None:
        """Makes one that is about to begin an episode.

        Raises:
            ValueError: See `check_smoothing`.
        """
        check_smoothing(spec, smoothing)
        self._spec = spec
        self._smoothing = smoothing
        self.begin()

    def begin(self) -> None:
        """Forgets what was executed: an episode begins."""
        self._last = rest(self._spec)

    def execute(self, action: int) -> Any:
        """What `env.step` wants for the chosen action's index, after those before it."""
        if self._smoothing == 1.0:
            return self._spec.to_env_action(action)
        self._last = smooth(self._spec, action, self._last, self._smoothing)
        return self._last.astype(np.float32)


def check_smoothing(spec: TaskSpec, smoothing: float) -> None:
    """Checks that a task's actions can be smoothed if they are to be.

    Raises:
        ValueError: If they are discrete: nothing lies between two of them.
    """
    if smoothing < 1.0 and spec.action_grid is None:
        raise ValueError(
            f"Expected action_smoothing to be 1 for {spec.env_id}, whose actions are discrete: "
            f"there is no mean of {spec.action_names[0]!r} and {spec.action_names[-1]!r}. But got "
            f"{smoothing:g}; leave it out."
        )


def rest(spec: TaskSpec) -> NDArray[np.float64]:
    """[dims] of NaN: what was executed before the first action of an episode, namely nothing."""
    dims = 0 if spec.action_grid is None else spec.action_grid.shape[1]
    return np.full(dims, np.nan)


def smooth(
    spec: TaskSpec, action: int, last: NDArray[np.float64], smoothing: float
) -> NDArray[np.float64]:
    """[dims] to execute for an action of a continuous task after `last` [dims], NaN for none."""
    assert spec.action_grid is not None
    chosen = spec.action_grid[action]
    return np.where(np.isnan(last), chosen, smoothing * chosen + (1.0 - smoothing) * last)


def last_executed(spec: TaskSpec, state: Any, episode_start: Any, n: int) -> NDArray[np.float64]:
    """[n, dims] what was executed last in `n` environments, NaN where an episode begins.

    Args:
        spec: Their task.
        state: What was executed last, as numbers that make [n, dims]; None: nothing yet.
        episode_start: Whether an episode begins, one truth or n of them; None: nowhere.
        n: How many environments there are.

    Raises:
        ValueError: If these are not numbers for n environments.
    """
    nothing = np.tile(rest(spec), (n, 1))
    if state is None:
        return nothing
    last = np.asarray(state, np.float64)
    if last.size != nothing.size or last.shape[-1:] != nothing.shape[-1:]:
        raise ValueError(
            f"Expected as state what predict returned for the {n} observations before, numbers "
            f"of shape {nothing.shape}, but got shape {last.shape}."
        )
    starts = np.asarray(False if episode_start is None else episode_start, np.bool_)
    return np.where(starts.reshape(-1, 1), nothing, last.reshape(nothing.shape))
