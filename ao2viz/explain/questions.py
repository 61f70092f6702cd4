"""What can be asked on the command line, by name."""

from enum import Enum


class Question(Enum):
    """A question; `docs/explanations.md` says what each answer proves."""

    WHY = "why"
    WHY_NOT = "why-not"
    FLIP = "flip"
    NEAREST_FLIP = "nearest-flip"
    AHEAD = "ahead"
    WEIGHT = "weight"
    OPTION = "option"
    NOVELTY = "novelty"
    FORGET = "forget"
    AGENT = "agent"
    MUTE = "mute"
    DISAGREE = "disagree"
