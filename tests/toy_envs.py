"""Small environments with one peculiarity each; importing this registers them."""

import gymnasium as gym
import numpy as np
from gymnasium import spaces


class Corridor(gym.Env):
    """Walk right to the end (+1, terminated); hitting the left end costs 1 (terminated)."""

    metadata = {"render_modes": ["rgb_array"]}  # noqa: RUF012  Gymnasium's own convention.

    def __init__(
        self,
        length: int = 5,
        start: int = 0,
        explode_at: int | None = None,
        bad: str = "",
        dtype: str = "float64",
        render_mode: str | None = None,
    ) -> None:
        self.render_mode = render_mode
        self.observation_space = spaces.Box(0, length, (2,), np.dtype(dtype).type)
        self.action_space = spaces.Discrete(2, start=start)
        self._length, self._explode_at, self._bad = length, explode_at, bad
        self._lived = 0
        self._state = np.zeros(2, dtype)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self._state[:] = self.np_random.integers(1, self._length - 1), 0
        return self._state, {}  # The very array that later steps write to.

    def step(self, action):
        assert self.action_space.contains(action), action
        self._lived += 1
        if self._lived == self._explode_at:
            raise RuntimeError("the corridor exploded")
        self._state[0] += 1 if action - self.action_space.start else -1
        self._state[1] += 1
        position = self._state[0]
        reward = 1.0 if position >= self._length else -1.0 if position <= 0 else 0.0
        if self._bad == "observation" and self._lived == 30:
            return np.array([np.nan, 0.0]), reward, False, False, {}
        if self._bad == "reward" and self._lived == 30:
            reward = np.inf
        return self._state, reward, bool(reward), False, {}

    def render(self):
        if self._bad == "picture":
            raise OSError("no paint left")
        picture = np.full((40, 60, 3), 255, np.uint8)
        picture[10:30, 10 * int(self._state[0]) : 10 * int(self._state[0]) + 10] = 0
        return picture


class Boxed(gym.Env):
    """Continuous actions of so many dimensions; each step returns the action as observation."""

    def __init__(self, dims: int = 1, width: float = 1.0) -> None:
        self.observation_space = spaces.Box(-np.inf, np.inf, (dims,), np.float32)
        self.action_space = spaces.Box(-width, width, (dims,), np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(self.action_space.shape, np.float32), {}

    def step(self, action):
        assert self.action_space.contains(action), action
        return action, -float(np.abs(action).sum()), False, False, {}


def _register(name: str, entry: type[gym.Env], limit: int, **settings: object) -> None:
    # Gymnasium would warn of what is wrong with them on purpose.
    gym.register(
        f"{name}-v0", entry, max_episode_steps=limit, disable_env_checker=True, kwargs=settings
    )


_register("Corridor", Corridor, limit=8)
_register("LongCorridor", Corridor, limit=4, length=50)
_register("ShiftedCorridor", Corridor, limit=8, start=5)
_register("WholeCorridor", Corridor, limit=8, dtype="int64")
_register("Exploding", Corridor, limit=8, explode_at=60)
_register("BadObservation", Corridor, limit=8, bad="observation")
_register("BadReward", Corridor, limit=8, bad="reward")
_register("BadPicture", Corridor, limit=8, bad="picture")
for _dims in (1, 2, 3):
    _register(f"Boxed{_dims}", Boxed, limit=5, dims=_dims)
