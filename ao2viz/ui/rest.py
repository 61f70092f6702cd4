"""When a browser's screen can stay as it is: a page that nobody touches should cost nothing."""

from dataclasses import replace

from ao2viz.ui.session import Session
from ao2viz.ui.world import World

STAYS_AWAKE_S = 0.8
"""After a change. What waits for a person to hold still waits for less."""
HEARTBEAT_S = 1.0
"""A screen at rest is looked at so often all the same, for whatever was not foreseen."""


class Rest:
    """Tells for one browser, tick by tick, whether its screen must be brought up to date."""

    def __init__(self) -> None:
        self._seen: tuple[Session, World, float] | None = None
        self._changed = 0.0
        self._looked = 0.0

    def wake(self) -> None:
        """Something happened that need not show in the session: a click that changed nothing."""
        self._seen = None

    def is_over(
        self, session: Session, world: World, camera: float, *, is_waiting: bool, now: float
    ) -> bool:
        """Whether anything may look different from what is on the screen.

        Args:
            session: What the browser chose.
            world: What all browsers share.
            camera: When its camera was heard of last.
            is_waiting: Whether an answer or a picture is on its way to this browser.
            now: The time, seconds.
        """
        # Of a place between two steps nothing shows.
        shown = replace(session, position=float(int(session.position)))
        seen = self._seen
        if seen is None or seen[1] is not world or seen[2] != camera or seen[0] != shown:
            self._seen, self._changed = (shown, world, camera), now
        is_awake = now - self._changed < STAYS_AWAKE_S or is_waiting
        if not is_awake and now - self._looked < HEARTBEAT_S:
            return False
        self._looked = now
        return True
