"""Asks step by step what has to be known of a state, so that a moved control costs little."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import Decision
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.ahead import Ahead
from ao2viz.explain.flips import Flips
from ao2viz.explain.telling import CHECKS
from ao2viz.ui.dials import Dial, make_dials
from ao2viz.ui.thinker import NoAnswer, Thinker
from ao2viz.ui.view import View

STILL_S = 0.25
"""A state is asked for its flips once it has not changed for so long."""


_NOTHING_TO_ASK = (
    "What if it had seen something else? That asks what was learned: watch a saved agent, or hold "
    "the run."
)
_GETTING_READY = "Getting ready to ask what was learned. The first time, that takes some seconds."


@dataclass(frozen=True, eq=False)
class Answer:
    """What is known by now of a state: the supposed one, or the one that was seen."""

    state: NDArray[np.float64]  # [D]
    is_supposed: bool
    dials: tuple[Dial, ...]  # [D]; empty while they are not known.
    decision: Decision | None = None
    ahead: Ahead | NoAnswer | None = None
    flips: Flips | NoAnswer | None = None
    faithfulness: Faithfulness | NoAnswer | None = None


class Supposing:
    """What one browser wants to know. It asks one thing after the other, the cheap ones first.

    So no more than one of its questions waits, and what has become of no interest is not asked.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._key: tuple[object, ...] = ()
        self._since = 0.0
        self._answer: Answer | None = None
        self._dials: tuple[object, tuple[Dial, ...]] = (None, ())

    def ask(self, view: View, thinker: Thinker) -> Answer | NoAnswer | None:
        """What is known now; the same object until there is more. None: nothing, or not yet."""
        learned, spec, forest = view.learned, view.spec, view.forest
        if learned is None or spec is None or forest is None or view.observation is None:
            self._answer = None
            return None
        is_supposed = view.supposed is not None
        state = view.observation if view.supposed is None else view.supposed
        key = (learned, is_supposed, state.tobytes())
        if key != self._key:
            self._key, self._since, self._answer = key, self._clock(), None
        if self._dials[0] is not learned:
            ranges = thinker.ranges(learned, spec)
            if ranges is None or isinstance(ranges, NoAnswer):
                return ranges
            self._dials = learned, make_dials(forest, ranges, spec)
        known = self._answer
        if known is None:
            known = Answer(state, is_supposed, self._dials[1])
        self._answer = self._more(known, view, thinker)
        return self._answer

    def _more(self, known: Answer, view: View, thinker: Thinker) -> Answer:
        """The next thing that is not known yet, if its answer is there."""
        learned, spec, state = view.learned, view.spec, known.state
        assert learned is not None
        assert spec is not None
        is_playing = view.transport.is_playing and not known.is_supposed
        if known.decision is None:
            if is_playing:
                return known
            answer = thinker.decision(learned, state)
            return known if not isinstance(answer, Decision) else replace(known, decision=answer)
        if known.ahead is None and view.shows_ahead:
            answer = thinker.ahead(learned, state)
            return known if answer is None else replace(known, ahead=answer)
        if is_playing or self._clock() - self._since < STILL_S:
            return known
        if known.flips is None:
            answer = thinker.flips(learned, spec, state)
            return known if answer is None else replace(known, flips=answer)
        if known.faithfulness is None:
            answer = thinker.faithfulness(learned, spec, view.recorded, CHECKS[Flips])
            return known if answer is None else replace(known, faithfulness=answer)
        return known


def why_nothing(view: View, asked: Answer | NoAnswer | None) -> str:
    """What to say where there is no answer to show."""
    if isinstance(asked, NoAnswer):
        return asked.words
    if view.learned is None or view.observation is None:
        return _NOTHING_TO_ASK
    return _GETTING_READY
