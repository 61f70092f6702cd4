"""Where a weight comes from and where a decision leads, as HTML; escaping as in `html`."""

import numpy as np

from ao2viz.core.decision import Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.ahead import Ahead, AheadEnd
from ao2viz.explain.contrast import explain_why_not, tell_why_not
from ao2viz.explain.origin import End, Origin
from ao2viz.explain.whole import Novelty
from ao2viz.explain.whole_telling import tell_novelty
from ao2viz.explain.words import amounts, count, number, percent
from ao2viz.ui.html import esc

_SHOWN_STEPS = 12
_SHOWN_WAY = 8


def reasons(origin: Origin, spec: TaskSpec) -> str:
    """The imagined story behind a weight, step by step, and what it comes to."""
    name = esc(spec.action_names[origin.action])
    parts = [
        f"<h4>Why {number(origin.weight)} for {name}</h4>"
        f"<p>Tried here {count(origin.visits, 'time')} since step {origin.born:,}.</p>"
    ]
    steps = origin.story.steps
    if not steps:
        parts.append(f"<p>What {name} does here is unknown: no option near has tried it.</p>")
    else:
        parts.append(
            f"<p>It imagines {count(len(steps), 'time')} {name}, from the option's value on:</p>"
        )
        parts.append(_story(origin, spec))
        after = origin.imagined - origin.story.reward
        parts.append(
            f"<p><b>{number(origin.imagined)}</b> = {number(origin.story.reward)} on the way + "
            f"{number(after)} from where it ends, both discounted.</p>"
        )
    if origin.is_by_trace and origin.trace is not None:
        parts.append(
            f"<p>A real trace from here earned more, and counts: {number(origin.trace.worth)}.</p>"
        )
    if origin.has_moved_on:
        parts.append(
            '<p class="ao-dim">Experience has moved on since the story that set this weight was '
            "imagined; here it is imagined anew.</p>"
        )
    return f'<div class="ao">{"".join(parts)}</div>'


def _story(origin: Origin, spec: TaskSpec) -> str:
    steps = origin.story.steps
    rows = []
    for n, step in enumerate(steps[:_SHOWN_STEPS], start=1):
        where = ", ".join(
            f"{feature.name} {shown}"
            for feature, shown in zip(spec.features, amounts(step.after, spec), strict=True)
        )
        ends = f", ends: {percent(step.ending)}" if step.ending > 0 else ""
        rows.append(
            f'<tr><td>{n}</td><td class="ao-num">earns {number(step.reward)}{ends}</td>'
            f'<td class="ao-num ao-dim">{count(step.visits, "visit")}</td></tr>'
            f'<tr><td></td><td colspan="2" class="ao-where">{esc(where)}</td></tr>'
        )
    if len(steps) > _SHOWN_STEPS:
        rows.append(f"<tr><td></td><td>{len(steps) - _SHOWN_STEPS} more</td><td></td></tr>")
    head = "<tr><th></th><th>each time</th><th>known from</th></tr>"
    return f'<table class="ao-story">{head}{"".join(rows)}</table>'


def why_nots(decision: Decision, spec: TaskSpec, view: ForestView) -> str:
    """What stood against each of the other actions, the strongest of them first; to be opened."""
    others = np.argsort(-decision.action_values, kind="stable").tolist()
    told = []
    for other in others:
        if other == decision.action:
            continue
        why_not = explain_why_not(decision, other, view)
        # An action drawn at random may have been expected to earn less than another.
        word = "less" if why_not.advantage >= 0 else "more"
        name = f"{spec.action_names[other]}: {number(abs(why_not.advantage))} {word} expected of it"
        told.append(
            f"<details><summary>{esc(name)}</summary>"
            f"<p>{esc(tell_why_not(why_not, spec))}</p></details>"
        )
    if not told:
        return ""
    return f'<div class="ao"><h4>Why not another action</h4>{"".join(told)}</div>'


def novelty(told: Novelty) -> str:
    """Whether the agent has met anything like what is seen; the alarm stands out."""
    kind = "ao-warn" if told.is_alarm else "ao-dim"
    return f'<div class="ao"><p class="{kind}">{esc(tell_novelty(told))}</p></div>'


def end_words(end: End) -> str:
    """What a button says that leads to one of the options where a story ends."""
    return f"{end.option} · {percent(end.share)}, worth {number(end.worth)}"


def ahead(way: Ahead, spec: TaskSpec) -> str:
    """Where the agent expects to go from here, in a few lines."""
    options = [stretch[0].option for stretch in way.stretches]
    shown = ", ".join(str(option) for option in options[:_SHOWN_WAY])
    rest = f" and {len(options) - _SHOWN_WAY} more" if len(options) > _SHOWN_WAY else ""
    first = spec.action_names[way.steps[0].action] if way.steps else ""
    begins = f"Beginning with {esc(first)}, by" if first else "By"
    way_told = f"{begins} way of the options {shown}{rest}." if options else ""
    least = min((step.visits for step in way.steps), default=0)
    known = f" The least known step rests on {count(least, 'visit')}." if way.steps else ""
    return (
        f'<div class="ao"><h4><span class="ao-key ao-key-ahead"></span>Where it expects to go</h4>'
        f"<p>{esc(ahead_words(way))}</p>"
        f'<p class="ao-gaps">{way_told}{known}</p></div>'
    )


def ahead_words(way: Ahead) -> str:
    """How far it sees, what it expects to earn on the way, and how that ends."""
    told = f"{count(len(way.steps), 'step')} ahead, {number(way.reward)} earned"
    match way.end:
        case AheadEnd.UNKNOWN:
            return f"{told}; beyond, it does not know what its action does."
        case AheadEnd.ENDED:
            return f"{told}; then it expects the episode to have ended."
        case AheadEnd.LIMIT:
            return f"{told}, and a chance of {percent(way.steps[-1].continues)} that it goes on."
