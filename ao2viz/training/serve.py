"""The loop of a worker on its own: commands in, work, the newest update out."""

import time
from collections.abc import Callable, Sequence

from ao2viz.training.states import USUAL_LEARNING, RunCommand, RunStatus
from ao2viz.training.updates import RunUpdate
from ao2viz.training.worker import Worker

MIN_INTERVAL_S = 0.1
"""Between two updates of a run; changes that people wait for are shown at once."""
MAX_INTERVAL_S = 1.0
"""However much one update cost: the first picture loads a library, and must not hide the next.

Both intervals are those of the usual share of learning.
"""
LONGEST_S = 30.0
"""However much all updates cost; a person must see that something goes on."""
SHORTEST_S = 1 / 30
"""No screen needs updates more often; what that leaves over goes into learning."""
_BUDGET_S = 0.02  # The longest that a command waits while training.

Receive = Callable[[float | None], Sequence[RunCommand] | None]
"""Waits at most so many seconds (None: for ever) for commands; gives None when it is time to go."""


class Pace:
    """When the next update is due: rarer the more it costs to make one, and the less is shown."""

    def __init__(self, learning_share: float = USUAL_LEARNING) -> None:
        self.learning_share = learning_share
        self._costs: tuple[float, ...] = ()  # Of the latest two.
        self._last = -MAX_INTERVAL_S

    @property
    def interval_s(self) -> float:
        """From the end of one update to the beginning of the next: what learning gets."""
        shown = 1.0 - self.learning_share
        for_each = self.learning_share / shown  # So that learning has its share of both.
        factor = (1.0 - USUAL_LEARNING) / shown
        shortest = max(SHORTEST_S, MIN_INTERVAL_S * factor)
        if not self._costs:
            return shortest
        # A single one that cost much may be an exception; two tell what they cost.
        once = min(MAX_INTERVAL_S * factor, self._costs[-1] * for_each)
        if not self._costs[1:]:
            return max(shortest, once)
        return max(shortest, once, min(LONGEST_S, min(self._costs) * for_each))

    def left_s(self, now: float) -> float:
        """Until the next is due; 0 if it is."""
        return max(0.0, self._last + self.interval_s - now)

    def note(self, began: float, ended: float) -> None:
        """Takes notice of an update that was made."""
        self._last, self._costs = ended, (*self._costs[-1:], ended - began)


def serve(worker: Worker, receive: Receive, publish: Callable[[RunUpdate], None]) -> None:
    """Runs a worker until `receive` says that it is time to go, then closes it."""
    pace, shown, wait_s = Pace(), -1, 0.0
    while (commands := receive(wait_s)) is not None:
        for command in commands:
            worker.handle(command)
        pace.learning_share = worker.learning_share
        now = time.perf_counter()
        is_running = worker.status is RunStatus.RUNNING
        if worker.changes != shown or (is_running and pace.left_s(now) == 0.0):
            # Read before, as drawing a picture may have something to tell as well.
            shown = worker.changes
            publish(worker.update())
            pace.note(now, time.perf_counter())
        # No longer than until the next update: with many a second, the rest of a turn counts.
        wait_s = worker.advance(min(_BUDGET_S, pace.left_s(time.perf_counter())))
        if worker.changes != shown:
            wait_s = 0.0
    worker.close()
