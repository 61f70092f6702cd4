"""The paper's learners beside a run, as HTML; escaping as in `html`."""

from collections.abc import Sequence

from ao2viz.explain.words import count, number
from ao2viz.figures.behind import Behind, Here
from ao2viz.figures.palette import LIGHT, to_css
from ao2viz.ui.html import esc
from ao2viz.ui.learners import Learners

_NONE = "–"


def why_none(learners: Learners) -> str:
    """Why there is nothing to lay behind; empty if there is something."""
    if learners.known:
        return ""
    if not learners.envs:
        words = "There are no learning curves here; ao2viz paper makes them."
    elif not learners.env:
        words = "No task is watched, so there are no learning curves of it."
    else:
        others = ", ".join(esc(env) for env in learners.envs)
        words = f"There are no learning curves of {esc(learners.env)}; there are of {others}."
    return f'<div class="ao"><p class="ao-dim">{words}</p></div>'


def beside_learners(learners: Learners, shown: Sequence[Behind]) -> str:
    """Where each learner was after as many steps, and when it was as good; says what the lines say.

    Args:
        learners: Where the run is.
        shown: A row each.
    """
    if not shown:
        return ""
    here = learners.here
    rows = "".join(_row(one, here) for one in shown)
    return (
        f'<div class="ao"><p>{_say_here(here)}</p><table><tr><th>learner</th><th>by then</th>'
        f"<th>as good after</th><th>in the end</th></tr>{rows}</table>"
        f'<p class="ao-dim">{_say_seeds(shown)}, evaluated now and then: AO2 by one path, networks '
        "greedily. The run's own episodes are those that it learns from.</p></div>"
    )


def _say_here(here: Here | None) -> str:
    if here is None:
        return "No training episode of this run has ended yet."
    episodes = f"its latest {count(here.episodes, 'episode')}"
    return f"You are at {count(here.steps, 'step')}: {number(here.value)} over {episodes}."


def _say_seeds(shown: Sequence[Behind]) -> str:
    counts = {len(one.seeds) for one in shown}
    least, most = min(counts), max(counts)
    return f"Means of {count(most, 'seed') if least == most else f'{least} to {most} seeds'}"


def _row(one: Behind, here: Here | None) -> str:
    mean, as_good, by_then = one.mean, _NONE, _NONE
    if here is not None:
        place, first = one.by(here.steps), one.first_at(here.value)
        by_then = _NONE if place is None else number(float(mean[place]))
        as_good = "never" if first is None else f"{one.steps[first]:,}"
    style = f"background:{to_css(one.color, one.color_in(LIGHT))}"
    swatch = f'<span class="ao-swatch{" ao-dashed" * one.is_dashed}" style="{style}"></span>'
    cells = (by_then, as_good, f"{number(float(mean[-1]))} at {one.steps[-1] / 1000:,.0f}k")
    told = "".join(f'<td class="ao-num">{cell}</td>' for cell in cells)
    return f"<tr><td>{swatch}{esc(one.learner)}</td>{told}</tr>"
