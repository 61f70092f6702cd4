"""Any explanation in plain sentences, by its kind."""

from collections.abc import Mapping

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Check, tell_faithfulness
from ao2viz.explain.ahead import Ahead, tell_ahead
from ao2viz.explain.contrast import WhyNot, tell_why_not
from ao2viz.explain.flips import Flips, tell_flips
from ao2viz.explain.forgetting import Forgotten, tell_forgotten
from ao2viz.explain.ledger import Account, tell_account
from ao2viz.explain.nearest import NearestFlip, tell_nearest
from ao2viz.explain.option import WholeOption, tell_option
from ao2viz.explain.origin import Origin, tell_origin
from ao2viz.explain.whole import Carriers, Comparison, Novelty, Overview
from ao2viz.explain.whole_telling import (
    tell_carriers,
    tell_comparison,
    tell_novelty,
    tell_overview,
)
from ao2viz.explain.why import Why, tell_why

Told = (
    Why
    | WhyNot
    | Flips
    | NearestFlip
    | Ahead
    | Origin
    | WholeOption
    | Account
    | Forgotten
    | Overview
    | Carriers
    | Comparison
    | Novelty
)
"""Every kind of explanation."""


CHECKS: Mapping[type, tuple[Check, ...]] = {
    Why: (Check.PARTS, Check.REPEATED),
    WhyNot: (Check.CONTRASTS, Check.REPEATED),
    Flips: (Check.LINES, Check.FLIPS, Check.CERTAIN),
    NearestFlip: (Check.LINES, Check.CERTAIN),
    Ahead: (Check.WAYS,),
    Origin: (Check.STORIES,),
    WholeOption: (Check.STORIES, Check.REPEATED),
    Carriers: (Check.REPEATED,),
    Comparison: (Check.REPEATED,),
    Novelty: (Check.DISTANCES,),
    Overview: (Check.PARTS, Check.LINES, Check.FLIPS, Check.CERTAIN, Check.REPEATED),
}
"""What is tried on recorded decisions to say how faithful each kind of answer is.

Those that learn again are checked against what was learned again.
"""


def tell(told: Told, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences, a line each; the last one says how faithful such are."""
    lines = _tell(told, spec)
    if told.faithfulness is not None and not isinstance(told, Overview):
        lines += (tell_faithfulness(told.faithfulness),)
    return lines


def _tell(told: Told, spec: TaskSpec) -> tuple[str, ...]:
    match told:
        case Why():
            return tell_why(told, spec)
        case WhyNot():
            return (tell_why_not(told, spec),)
        case Flips():
            return tell_flips(told, spec)
        case NearestFlip():
            return tell_nearest(told, spec)
        case Ahead():
            return tell_ahead(told, spec)
        case Origin():
            return tell_origin(told, spec)
        case WholeOption():
            return tell_option(told, spec)
        case Account():
            return tell_account(told, spec)
        case Forgotten():
            return tell_forgotten(told, spec)
        case Overview():
            return tell_overview(told, spec)
        case Carriers():
            return tell_carriers(told)
        case Comparison():
            return tell_comparison(told, spec)
        case Novelty():
            return (tell_novelty(told),)
