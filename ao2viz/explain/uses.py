"""Where in recorded episodes an option was asked; pure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ao2viz.recording.episode import Episode


@dataclass(frozen=True)
class Use:
    """One recorded step at which an option had a say."""

    episode: int  # Its place among the recorded ones.
    step: int
    action: int  # What was done.
    share: float  # Of the say; 1 if the option decided alone.


def find_uses(episodes: Sequence[Episode], option: int, action: int | None = None) -> list[Use]:
    """Every recorded step at which the option had a say; with an action only where that was done.

    In the order of recording.
    """
    found = []
    for number, episode in enumerate(episodes):
        for step, decision in enumerate(episode.decisions):
            if action is not None and decision.action != action:
                continue
            place = np.flatnonzero(decision.voters == option)
            if len(place) and decision.shares[place[0]] > 0:
                share = float(decision.shares[place[0]])
                found.append(Use(number, step, decision.action, share))
    return found
