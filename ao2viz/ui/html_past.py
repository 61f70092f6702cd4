"""What is told about a past moment of a forest, as HTML; escaping as in `html`."""

from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import Decision
from ao2viz.explain.words import count, number, told_apart
from ao2viz.ui.html import esc
from ao2viz.ui.html_forest import GREY
from ao2viz.ui.view import Back, View


def say_back(back: Back) -> str:
    """That this is not now, in one line."""
    return f"You are looking at step {back.moment.step:,} of {back.past.n_steps:,} of training."


def canvas_line(view: View) -> str:
    """The same beside the canvas; nothing while now is shown."""
    if view.back is None:
        return ""
    return f'<div class="ao"><p class="ao-banner">{esc(say_back(view.back))}</p></div>'


def say_grey(back: Back | None) -> str:
    """What grey options tell: in the past mostly that nothing was kept of them."""
    if back is None:
        return GREY
    if back.moment.snapshot is None:
        return "weights of then are not known"
    return "had tried nothing, or is newer"


def of_now(view: View, words: str) -> str:
    """That something tells of now beside a canvas that shows the past; else nothing."""
    if view.back is None:
        return ""
    return f'<div class="ao"><p class="ao-warn">{esc(words)}</p></div>'


def past_facts(view: View, then: Decision | None) -> str:
    """What there was at the moment that is shown, and what the agent would have done."""
    back = view.back
    if view.n_lived == 0:
        words = "Of this forest's past nothing is known."
        if view.learned is None:
            words = "The past can be looked at once the run is paused, or an agent is open."
        return f'<div class="ao"><p class="ao-dim">{words}</p></div>'
    if back is None:
        words = (
            f"{count(view.n_lived, 'step')} of training. Move the slider to see the forest as it "
            "was after any of them, and what the agent would have done then."
        )
        return f'<div class="ao"><p class="ao-dim">{words}</p></div>'
    standing, now = len(back.moment.view), len(back.past.now)
    lines = [
        f"{count(standing, 'option')} stood then, {now:,} stand now. Room is kept for all that "
        "ever stood, so the forest is arranged otherwise than now."
    ]
    if len(back.returns):
        mean = number(float(back.returns.mean()))
        lines.append(f"Return then: {mean}, the mean of the {_episodes(len(back.returns))} before.")
    else:
        lines.append("No training episode had ended.")
    lines.append(_weights(back))
    lines += _decision(view, then)
    return f'<div class="ao">{"".join(f"<p>{esc(each)}</p>" for each in lines)}</div>'


def _episodes(n: int) -> str:
    return "one episode" if n == 1 else f"{n} episodes"


def _weights(back: Back) -> str:
    known = back.moment.snapshot
    if known is not None:
        return (
            f"Weights, visits and attention are those after step {known:,}, the last ones kept "
            "before; options made since are grey."
        )
    if back.past.snapshots:
        first = back.past.snapshots[0].step
        return f"Weights are kept from step {first:,} on; here only the structure is known."
    return "This file keeps no weights of the past, so only the structure is shown."


def _decision(view: View, then: Decision | None) -> list[str]:
    back, spec = view.back, view.spec
    if then is None or back is None or back.moment.snapshot is None or spec is None:
        return []
    step = f"{back.moment.snapshot:,}"
    if len(then.voters) == 0:
        return [f"After step {step} there were no options to ask yet."]
    name, other = spec.action_names[then.action], spec.action_names[then.runner_up_action]
    text = f"Seeing what the replay shows, it would have chosen {name} after step {step}"
    if then.is_tie:
        text += ", by a tie"
    elif then.runner_up_action != then.action:
        high, low = told_apart(
            float(then.action_values[then.action]),
            float(then.action_values[then.runner_up_action]),
        )
        text += f": it expected {high} of that, and {low} of {other}"
    lines = [f"{text}."]
    if view.decision is not None:
        same = view.decision.action == then.action
        recorded = spec.action_names[view.decision.action]
        lines.append("The same as recorded." if same else f"Recorded: {recorded}.")
    if isinstance(view.config, AnticipatingConfig) and view.config.think_ahead:
        lines.append("It is asked without thinking ahead.")
    return lines
