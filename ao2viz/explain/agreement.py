"""How often explanations agree with the agent: what was counted, and the words for it."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ao2viz.explain.words import count


class Check(Enum):
    """What can be tried on recorded decisions; the values are the fields of `Faithfulness`."""

    PARTS = "parts"
    CONTRASTS = "contrasts"
    LINES = "lines"
    FLIPS = "flips"
    CERTAIN = "certain"
    WAYS = "ways"
    STORIES = "stories"
    DISTANCES = "distances"
    REPEATED = "repeated"
    LEARNED = "learned"


_TOLD: Mapping[Check, str] = {
    Check.PARTS: "parts add up to the choice",
    Check.CONTRASTS: "contrasts with the next best add up to the lead",
    Check.LINES: "lines tell the action",
    Check.FLIPS: "flips flip",
    Check.CERTAIN: "places nearer than what is certain keep the action",
    Check.WAYS: "ways begin with what it does",
    Check.STORIES: "stories come to the weight",
    Check.DISTANCES: "distances are those by which it decided",
}
_AGAIN: Mapping[Check, str] = {
    Check.REPEATED: "asked again, it decides as recorded in",
    Check.LEARNED: "learned again, it decides the same in",
}


@dataclass(frozen=True)
class Agreement:
    """On how many of the states that it was tried on an explanation agrees with the agent."""

    agreed: int
    tried: int

    @property
    def share(self) -> float:
        """NaN if nothing could be tried."""
        return self.agreed / self.tried if self.tried else np.nan


NOT_TRIED = Agreement(0, 0)


@dataclass(frozen=True)
class Faithfulness:
    """How often explanations of each kind agreed with the agent; those that do not count here: 0.

    Reported with every answer: of the kinds that the answer rests on.
    """

    parts: Agreement = NOT_TRIED  # `why`: the parts it names add up to the choice that was made.
    contrasts: Agreement = NOT_TRIED  # `why_not`: so do those of the lead over the next best.
    lines: Agreement = NOT_TRIED  # `flips`: what its pieces say of the state, along every feature.
    flips: Agreement = NOT_TRIED  # `flips`: the agent, asked at a reported flip, does choose so.
    certain: Agreement = NOT_TRIED  # `flips`: so it does not within the certified radius.
    ways: Agreement = NOT_TRIED  # `ahead`: the first action is what the agent does.
    stories: Agreement = NOT_TRIED  # `weight`: imagined anew, a story gives the weight, to 0.1 %.
    distances: Agreement = NOT_TRIED  # `novelty`: the distance is the one that decided.
    repeated: Agreement = NOT_TRIED  # Asked again now, the agent still decides as it is recorded.
    learned: Agreement = NOT_TRIED  # `ledger`, `forget`: learned again, it decides the same.
    states: int = 0  # At so many something was tried.
    are_recorded: bool = True  # Else they are options' values, as nothing is recorded.

    def __getitem__(self, check: Check) -> Agreement:
        """What came of one check."""
        return vars(self)[check.value]


def tell_faithfulness(told: Faithfulness) -> str:
    """How often each kind of explanation that was tried agreed with the agent."""
    # A rounded share of all would hide the one that is not.
    said = {check: told[check] for check in Check if told[check].tried}
    parts = [
        f"{said[check].agreed:,} of {said[check].tried:,} {words}"
        for check, words in _TOLD.items()
        if check in said
    ]
    parts += [
        f"{words} {said[check].agreed:,} of {said[check].tried:,}"
        for check, words in _AGAIN.items()
        if check in said
    ]
    if not parts:
        return "Faithfulness: nothing could be tried."
    where = count(told.states, "recorded state" if told.are_recorded else "option")
    return f"Faithfulness, tried at {where}: {'; '.join(parts)}."
