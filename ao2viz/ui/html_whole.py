"""What is known of a whole agent, as HTML; escaping as in `html`."""

import numpy as np

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import tell_faithfulness
from ao2viz.explain.whole import MOST_SEARCHED, MOST_STATES, Attended, Highlight, Muted
from ao2viz.explain.whole_telling import tell_carriers, tell_coverage, tell_roles
from ao2viz.explain.words import count, number, percent
from ao2viz.ui.html import esc, faithful
from ao2viz.ui.jobs import JobState
from ao2viz.ui.whole import Playing, Portrait, Whole

_MOST_FEATURES = 20  # Those with the greatest shares; the rest are told as one.
_STAND_IN = (
    "No decision is recorded, so its options' values stand in for what it sees: an option covers "
    "its own. Record episodes (ao2viz record) to learn how it does where it goes."
)
_IS_AT_VALUES = "every state is an option's value, so no distance keeps it from who decides"
_CARRIERS = (
    '<div class="ao"><h4>Which options carry the return</h4><p class="ao-dim">Each is muted, as if '
    "it had never been, and the same greedy episodes are played again. Two options that stand in "
    "for each other are each without loss.</p></div>"
)


def heading(whole: Whole) -> str:
    """What is asked, over what, and of which agent."""
    if whole.problem:
        return f'<div class="ao"><p class="ao-dim">{esc(whole.problem)}</p></div>'
    kind = "recorded state" if whole.are_recorded else "option"
    lines = [f"Counted over {count(whole.states, kind)}.{_sampled(whole.states)}"]
    if not whole.are_recorded:
        lines.append(_STAND_IN)
    if whole.beside:
        lines.append(f"Of the agent that is watched, not of “{whole.beside}” beside it.")
    told = "".join(f'<p class="ao-dim">{esc(line)}</p>' for line in lines)
    return f'<div class="ao"><h4>The agent as a whole</h4>{told}</div>'


def _sampled(states: int) -> str:
    """How many are taken where that is not all of them."""
    if states > MOST_SEARCHED:
        return (
            f" Of them {MOST_SEARCHED:,} are taken, evenly spread, and {MOST_STATES:,} where each "
            "takes many decisions."
        )
    if states > MOST_STATES:
        return f" Where each takes many decisions, {MOST_STATES:,} of them, evenly spread."
    return ""


def progress(job: JobState | None) -> str:
    """How far counting has come; nothing when all is known."""
    if job is None:
        return ""
    if job.error:
        return _trouble(job.error)
    if not job.is_done:
        portrait = portrait_of(job)
        words = f"Getting the agent ready, {job.seconds:.0f} s …"
        if portrait is not None:
            part = "roles" if portrait.roles is None else "faithfulness"
            words = f"Counting {part}, {percent(share_of(job))}, {job.seconds:.0f} s …"
    elif not isinstance(job.latest, Portrait) or not job.latest.is_complete:
        words = "Ended before all was counted; what is known so far stands below."
    else:
        return ""
    return f'<div class="ao"><p class="ao-dim" role="status">{words}</p></div>'


def _trouble(words: str) -> str:
    return f'<div class="ao"><p class="ao-error" role="status">{esc(words)}</p></div>'


def portrait_of(job: JobState | None) -> Portrait | None:
    """What has been counted by now."""
    return job.latest if job is not None and isinstance(job.latest, Portrait) else None


def share_of(job: JobState | None) -> float:
    """The share of the work that is done."""
    latest = job.latest if job is not None else None
    if isinstance(latest, Portrait):
        return latest.share
    return latest.played / latest.planned if isinstance(latest, Playing) else 0.0


def attention(portrait: Portrait | None, spec: TaskSpec) -> str:
    """The share of the distance per feature, in numbers and as bars, the greatest first."""
    told = portrait.attention if portrait is not None else None
    if told is None:
        return ""
    by = told.shares if told.states else told.runner_up_shares
    order = np.argsort(-by, kind="stable").tolist()
    shown, rest = order[:_MOST_FEATURES], order[_MOST_FEATURES:]
    rows = [_share_row(spec.features[d].name, told, [d]) for d in shown]
    if rest:
        rows.append(_share_row(f"{len(rest):,} more", told, rest))
    over = f"over {count(told.states, 'state')}" if told.states else _IS_AT_VALUES
    return (
        '<div class="ao"><h4>What it attends to</h4><p class="ao-dim">Each feature\'s share of the '
        f"distance to the option that decides, and to the runner-up: {over}.</p>"
        '<table class="ao-shares"><tr><th scope="col">feature</th><th scope="col">decides</th>'
        f'<th scope="col">runner-up</th></tr>{"".join(rows)}</table></div>'
    )


def _share_row(name: str, told: Attended, features: list[int]) -> str:
    cells = []
    for shares, kind, is_known in (
        (told.shares, "", told.states > 0),
        (told.runner_up_shares, "ao-dashed", True),
    ):
        share = float(shares[features].sum())
        bar = (
            f'<span class="ao-bar" aria-hidden="true"><span class="{kind}" '
            f'style="width:{100 * share:.0f}%"></span></span>'
        )
        words = percent(share) if is_known else "–"
        cells.append(f'<td class="ao-num">{words}{bar if is_known else ""}</td>')
    return f"<tr><td>{esc(name)}</td>{''.join(cells)}</tr>"


def highlight_words(one: Highlight) -> str:
    """Where to look, and how much the choice mattered."""
    return f"Episode {one.episode + 1}, step {one.step}: {number(one.importance)} at stake"


def coverage(portrait: Portrait | None) -> str:
    """How much of where it goes is known to it."""
    told = portrait.coverage if portrait is not None else None
    if told is None:
        return ""
    return (
        f'<div class="ao"><h4>How well it knows where it goes</h4><p>{esc(tell_coverage(told))}</p>'
        "</div>"
    )


def roles(portrait: Portrait | None) -> str:
    """Who decides, who supports, who could be spared."""
    told = portrait.roles if portrait is not None else None
    if told is None or not told.states:
        return ""
    return f'<div class="ao"><h4>Who decides</h4><p>{esc(tell_roles(told))}</p></div>'


def faithfulness(portrait: Portrait | None) -> str:
    """How often the explanations that all this rests on agree with the agent."""
    return faithful(portrait.faithfulness if portrait is not None else None)


def carriers_heading() -> str:
    """What muting options is."""
    return _CARRIERS


def carriers(job: JobState | None) -> str:
    """How far playing without options has come; what each is worth stands in the list below."""
    if job is None:
        return ""
    if job.error:
        return _trouble(f"This cannot be played here. {job.error}")
    playing = job.latest
    lines: list[str] = []
    if not job.is_done:
        lines.append(f"{_played(playing)}, {job.seconds:.0f} s …")
    if isinstance(playing, Playing) and playing.told is not None:
        every, *_ = tell_carriers(playing.told)
        lines.append(every)
        if job.is_done and not playing.told.is_complete:
            lines.append(f"Ended: {_played(playing)}. What is known so far stands below.")
        if playing.told.faithfulness is not None:
            lines.append(tell_faithfulness(playing.told.faithfulness))
    elif job.is_done:
        lines.append("Ended before anything was known.")
    told = "".join(f'<p class="ao-dim">{esc(line)}</p>' for line in lines)
    return f'<div class="ao" role="status">{told}</div>'


def _played(playing: object) -> str:
    if not isinstance(playing, Playing):
        return "Making the environment"
    return f"{playing.played:,} of {count(playing.planned, 'episode')} played"


def muted_words(one: Muted) -> str:
    """What the return is without an option, and what that loses."""
    error = "" if np.isnan(one.standard_error) else f" ± {number(one.standard_error)}"
    return f"Option {one.option}: a loss of {number(one.loss)}{error}, to {number(one.mean_return)}"
