"""Two agents beside each other, as HTML; escaping as in `html`."""

from collections.abc import Sequence

import numpy as np

from ao2viz.core.decision import Decision
from ao2viz.envs.task import TaskSpec
from ao2viz.experiments.duel import Beside, Duel, Returns
from ao2viz.explain.compare import Setting, tell_forests
from ao2viz.explain.words import amounts, count, number, percent
from ao2viz.ui.html import colors_of, esc
from ao2viz.ui.jobs import JobState

NOTHING_CHOSEN = (
    '<div class="ao"><p class="ao-dim">Choose another agent of the same task: a checkpoint of the '
    "same one, or one that learned otherwise. “Here” is what is watched, “there” the "
    "other.</p></div>"
)
_HEAD = "<tr><th></th><th>here</th><th>there</th></tr>"


def at_this_step(here: Decision | None, there: Decision | None, spec: TaskSpec) -> str:
    """What each would do at the moment that is watched."""
    if here is None or there is None:
        return ""
    differs = here.action != there.action
    mark = '<span class="ao-mark">they part here</span>' if differs else ""
    rows = [
        ("would do", *(_action(one, spec) for one in (here, there))),
        ("margin", number(here.margin), number(there.margin)),
        ("option", *(str(one.path[-1]) if len(one.path) else "–" for one in (here, there))),
    ]
    return f'<div class="ao"><h4>At this moment</h4>{mark}{_table(rows)}</div>'


def _action(decision: Decision, spec: TaskSpec) -> str:
    color = colors_of(spec)[decision.action]
    swatch = f'<span class="ao-swatch" style="background:{color}"></span>'
    return f"{swatch}{esc(spec.action_names[decision.action])}"


def _table(rows: Sequence[tuple[str, ...]]) -> str:
    """A table of names and two columns; the cells are HTML."""
    body = "".join(
        f'<tr><td>{name}</td><td class="ao-num">{here}</td><td class="ao-num">{there}</td></tr>'
        for name, here, there in rows
    )
    return f"<table>{_HEAD}{body}</table>"


def beside(job: JobState | None) -> str:
    """How often the two differ, over the episode and over everything recorded."""
    if job is None or (not job.is_done and job.latest is None):
        return '<div class="ao"><p class="ao-dim" role="status">Comparing …</p></div>'
    if job.error or not isinstance(job.latest, Beside):
        return f'<div class="ao"><p class="ao-error">{esc(job.error or "Called off.")}</p></div>'
    told = job.latest
    lines = []
    if len(told.episode.states):
        n = len(told.episode.disagreements)
        lines.append(
            f"At the states of this episode they part in {n:,} of "
            f"{count(len(told.episode.states), 'step')} ({percent(told.episode.share)})."
        )
    if len(told.recorded.states):
        n = len(told.recorded.disagreements)
        lines.append(
            f"Over {count(len(told.recorded.states), 'recorded state')} of both they part in "
            f"{n:,} ({percent(told.recorded.share)})."
        )
    return f'<div class="ao">{"".join(f"<p>{line}</p>" for line in lines)}</div>'


def returns(told: Beside) -> str:
    """Returns of the recorded episodes."""
    rows = [
        ("episodes", *(f"{len(one.scores):,}" for one in told.returns)),
        ("mean *", *(number(one.iqm) if len(one.scores) else "–" for one in told.returns)),
        ("95 % interval", *map(_interval, told.returns)),
    ]
    note = "* of the middle half; the interval is a bootstrap over episodes."
    return (
        f'<div class="ao"><h4>Returns as recorded</h4>{_table(rows)}'
        f'<p class="ao-dim">{note}</p></div>'
    )


def _interval(one: Returns) -> str:
    if one.interval is None:
        return "–"
    return f"{number(one.interval[0])} to {number(one.interval[1])}"


def duel(job: JobState | None, step: int, spec: TaskSpec) -> str:
    """Both agents' own episodes at one step, and their returns so far."""
    if job is None:
        return (
            '<div class="ao"><p class="ao-dim">Both play from this seed, step by step beside each '
            "other, then 20 episodes each for their returns.</p></div>"
        )
    if job.error:
        return f'<div class="ao"><p class="ao-error">{esc(job.error)}</p></div>'
    if not isinstance(job.latest, Duel):
        return '<div class="ao"><p class="ao-dim" role="status">Both play …</p></div>'
    told = job.latest
    parting = told.parting
    first = "They do the same from beginning to end."
    if parting is not None:
        first = f"They part at step {parting}."
    return f'<div class="ao"><p>{first}</p>{_duel_step(told, step, spec)}</div>'


def _duel_step(told: Duel, step: int, spec: TaskSpec) -> str:
    cells: list[list[str]] = []
    for episode in (told.one, told.other):
        at = min(step, len(episode))
        if at < len(episode):
            does = _action(episode.decisions[at], spec)
        else:
            does = f"ended, step {len(episode)}"
        earned = number(float(episode.rewards[:at].sum()))
        cells.append([does, earned, *map(esc, amounts(episode.observations[at], spec))])
    names = ["does", "earned so far", *(esc(feature.name) for feature in spec.features)]
    return _table(list(zip(names, *cells, strict=True)))


def duel_returns(job: JobState | None) -> str:
    """How the episodes for returns came out, pair by pair from the same seeds."""
    if job is None or not isinstance(job.latest, Duel):
        return ""
    told = job.latest
    state = f"{told.played} of {told.planned} episodes each"
    if not job.is_done:
        state += f", {job.seconds:.0f} s …"
    elif told.played < told.planned:
        state += ", then ended"
    if told.played == 0:
        return f'<div class="ao"><p class="ao-dim" role="status">{state}</p></div>'
    rows = [
        ("mean *", *(number(one.iqm) for one in told.returns)),
        ("95 % interval", *map(_interval, told.returns)),
    ]
    return (
        f'<div class="ao"><h4>Returns from the same seeds</h4>'
        f'<p class="ao-dim" role="status">{state}</p>{_table(rows)}<p>{_verdict(told.difference)}'
        f'</p><p class="ao-dim">* of the middle half; intervals are bootstraps over episodes.</p>'
        "</div>"
    )


def _verdict(difference: Returns) -> str:
    """Which of the two earns more, as far as these episodes tell."""
    if difference.interval is None:
        return ""
    low, high = difference.interval
    told = f"Pair by pair here less there: {number(difference.iqm)} ({_interval(difference)})."
    if low > 0:
        return f"{told} Here earns more."
    if high < 0:
        return f"{told} There earns more."
    if np.ptp(difference.scores) == 0 and difference.iqm == 0:
        return f"{told} They earn the same."
    return f"{told} These episodes do not tell which earns more."


def forests(told: Beside) -> str:
    """How much of the forests is the same."""
    return f'<div class="ao"><h4>Forests</h4><p>{esc(tell_forests(told.forests))}</p></div>'


def settings(found: tuple[Setting, ...]) -> str:
    """The settings in which they differ."""
    if not found:
        return '<div class="ao"><h4>Settings</h4><p>All settings are the same.</p></div>'
    rows = [
        (
            esc(one.name.replace("_", " ")),
            *("–" if side is None else esc(side) for side in (one.here, one.there)),
        )
        for one in found
    ]
    return f'<div class="ao"><h4>Settings that differ</h4>{_table(rows)}</div>'
