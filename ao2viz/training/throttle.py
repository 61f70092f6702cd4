"""How fast a run goes: the limit that people set, and the steps a second that it reaches."""

from collections import deque
from collections.abc import Callable

# A throttled run sleeps at least this long at a time, then catches up.
_SHORTEST_WAIT_S = 0.002
# Steps a second are counted over about this long.
_SPEED_WINDOW_S = 2.0


class Throttle:
    """Counts steps against a clock; told of every start and stop. Seconds throughout."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """Makes one without a limit."""
        self._clock = clock
        self.speed: float | None = None  # Steps a second at most; None: no limit.
        self._began = (0.0, 0)  # When and at which step throttling began.
        self._pace: deque[tuple[float, int]] = deque()  # (time, step) while running.

    def set_limit(self, steps_per_s: float | None, n_steps: int) -> None:
        """Sets the limit, more than 0; None lifts it. `n_steps` have been taken."""
        self.speed = steps_per_s
        self.restart(n_steps)

    def restart(self, n_steps: int) -> None:
        """Forgets the time that has passed; `n_steps` have been taken."""
        self._began = (self._clock(), n_steps)
        self._pace.clear()

    def wait_s(self, now: float, n_steps: int) -> float:
        """How long the run must wait before its next step."""
        if self.speed is None:
            return 0.0
        began, first = self._began
        due = began + (n_steps - first) / self.speed
        return max(due - now, _SHORTEST_WAIT_S) if due > now else 0.0

    def measure(self, n_steps: int) -> float:
        """Steps a second of late, counted from one call to another."""
        now = self._clock()
        self._pace.append((now, n_steps))
        while len(self._pace) > 2 and now - self._pace[1][0] > _SPEED_WINDOW_S:
            self._pace.popleft()
        began, first = self._pace[0]
        return (n_steps - first) / (now - began) if now > began else 0.0
