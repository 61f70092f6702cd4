"""What would be, as HTML; escaping as in `html`."""

import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.catalogue import Feature
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.flips import FeatureFlips, Flip, FlipKind, Flips
from ao2viz.explain.nearest import NearestFlip, tell_nearest
from ao2viz.explain.what_if import tell_certainty
from ao2viz.explain.words import amount, count, percent
from ao2viz.ui.html import esc, faithful
from ao2viz.ui.jobs import JobState
from ao2viz.ui.what_if import NEAREST_TIME_S


def banner(changed: list[str], *, is_supposed: bool) -> str:
    """Whether this is the replay's moment or a what-if, and what was changed."""
    if is_supposed:
        what = f"Changed: {esc(', '.join(changed))}. " if changed else ""
        return (
            f'<div class="ao"><p class="ao-supposed"><b>A what-if, not the replay.</b> {what}The '
            "forest shows what the agent would do here.</p></div>"
        )
    return (
        '<div class="ao"><p class="ao-dim">This is the moment of the replay. Move a control: the '
        "path, the reasons and the action follow.</p></div>"
    )


def dial(feature: Feature, value: float, seen: float) -> str:
    """What stands over a control: the feature, its value, and what was seen if that differs."""
    was = ""
    if value != seen:
        was = f' <span class="ao-dim">seen {esc(amount(seen, feature))}</span>'
    return (
        f'<span class="ao-dial"><span>{esc(feature.name)}</span><span class="ao-num">'
        f"{was} <b>{esc(amount(value, feature))}</b></span></span>"
    )


def flip_words(flip: Flip | None, spec: TaskSpec, *, is_more: bool) -> str:
    """What the button of a flip says."""
    if flip is None:
        return "no flip above" if is_more else "no flip below"
    place = amount(flip.beyond, spec.features[flip.feature])
    mark = "" if flip.is_familiar else " *"
    if flip.kind is FlipKind.TIE:
        return f"a toss at {place}{mark}"
    return f"{spec.action_names[flip.action]} at {place}{mark}"


def certainty(
    flips: Flips, faithfulness: Faithfulness | None, attention: NDArray[np.float64], spec: TaskSpec
) -> str:
    """What is certain around here, and how often such explanations proved right."""
    told = [f"<p>{esc(tell_certainty(flips, attention, spec))}</p>"]
    if any(_is_new(both) for both in flips.features):
        told.append('<p class="ao-dim">A flip marked * lies beyond all that the agent has met.</p>')
    return f'<div class="ao"><h4>How sure</h4>{"".join(told)}</div>{faithful(faithfulness)}'


def _is_new(both: FeatureFlips) -> bool:
    return any(flip is not None and not flip.is_familiar for flip in (both.less, both.more))


def nearest(job: JobState | None, spec: TaskSpec) -> str:
    """How far the search for the nearest flip of all features has come."""
    if job is None:
        return ""
    found = job.latest if isinstance(job.latest, NearestFlip) else None
    if job.error:
        told = f'<p class="ao-error">{esc(job.error)}</p>'
    elif found is None:
        told = f"<p>Beginning … {_clock(job)}</p>"
    else:
        told = "".join(f"<p>{esc(line)}</p>" for line in tell_nearest(found, spec))
        programs = count(found.solved, "program")
        if not job.is_done:
            told += (
                f'<p class="ao-dim">Still searching: {programs} solved, {found.waiting:,} wait, '
                f"known to {percent(1 - found.gap)}. {_clock(job)}</p>"
            )
        elif not found.is_complete:
            told += f'<p class="ao-dim">The search was cut short after {programs}.</p>'
        else:
            told += f'<p class="ao-dim">Proven with {programs} in {job.seconds:.1f} s.</p>'
    return f'<div class="ao" role="status"><h4>Nearest flip of all features</h4>{told}</div>'


def _clock(job: JobState) -> str:
    return f"{job.seconds:.0f} s of at most {NEAREST_TIME_S:.0f} s."
