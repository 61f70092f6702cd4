"""Any explanation in plain sentences, by its kind."""

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.ahead import Ahead, tell_ahead
from ao2viz.explain.contrast import WhyNot, tell_why_not
from ao2viz.explain.flips import Flips, tell_flips
from ao2viz.explain.forgetting import Forgotten, tell_forgotten
from ao2viz.explain.ledger import Account, tell_account
from ao2viz.explain.nearest import NearestFlip, tell_nearest
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
    | Account
    | Forgotten
    | Overview
    | Carriers
    | Comparison
    | Novelty
)
"""Every kind of explanation."""


def tell(told: Told, spec: TaskSpec) -> tuple[str, ...]:
    """The explanation in sentences, a line each."""
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
