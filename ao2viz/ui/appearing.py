"""What a command about the look of the page changes in a session; pure, a part of `reduce`."""

from dataclasses import replace

from ao2viz.ui.appearance import AppearanceCommand, Recall, Remember, change, to_text
from ao2viz.ui.session import Session


def appear(session: Session, command: AppearanceCommand) -> tuple[Session, tuple[Remember, ...]]:
    """The session after a command, and what the browser is to keep."""
    changed = replace(session, appearance=change(session.appearance, command))
    if isinstance(command, Recall):
        # Whoever wants nothing to move is not met by an episode that plays.
        is_playing = session.is_playing and not changed.appearance.rests
        return replace(changed, is_playing=is_playing), ()
    return changed, (Remember(to_text(changed.appearance)),)
