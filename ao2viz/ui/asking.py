"""What a browser's screen asks of the agent that it shows, as far as that is known by now."""

from collections.abc import Sequence

from ao2viz.core.decision import Decision
from ao2viz.explain.agreement import Check, Faithfulness
from ao2viz.explain.ahead import Ahead
from ao2viz.explain.whole import Novelty
from ao2viz.ui.thinker import Thinker
from ao2viz.ui.view import View
from ao2viz.ui.watched import learned_at


def decision_then(view: View, thinker: Thinker) -> Decision | None:
    """What the past agent that is shown would decide at the state of the replay."""
    back = view.back
    if back is None or back.moment.snapshot is None:
        return None
    if view.observation is None or view.config is None:
        return None
    learned = learned_at(back.past, back.moment.snapshot, view.config)
    answer = thinker.decision(learned, view.observation)
    return answer if isinstance(answer, Decision) else None


def faithful_of(view: View, thinker: Thinker, checks: Sequence[Check]) -> Faithfulness | None:
    """How often explanations of a kind agree with the agent."""
    if view.learned is None or view.spec is None:
        return None
    answer = thinker.faithfulness(view.learned, view.spec, view.recorded, checks)
    return answer if isinstance(answer, Faithfulness) else None


def ahead_of(view: View, thinker: Thinker) -> Ahead | None:
    """Where the agent expects to go from what is seen."""
    if not view.shows_ahead or view.walk is not None:
        return None
    if view.learned is None or view.decision is None:
        return None
    answer = thinker.ahead(view.learned, view.decision.observation)
    return answer if isinstance(answer, Ahead) else None


def novelty_of(view: View, thinker: Thinker) -> Novelty | None:
    """Whether the agent has met anything like what is seen; not asked of each step that plays."""
    if view.learned is None or view.decision is None or view.transport.is_playing:
        return None
    answer = thinker.novelty(view.learned, view.decision.observation, view.recorded)
    return answer if isinstance(answer, Novelty) else None
