"""Text panels as HTML. Rule: whatever comes from a file, an id or an error goes through `esc`."""

import html as _html

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness, tell_faithfulness
from ao2viz.explain.sentence import PathStep, explain, path_steps
from ao2viz.explain.words import amounts, count, number, percent, told_apart
from ao2viz.figures.palette import DARK, LIGHT, action_colors, to_css

_SHOWN_GAPS = 2
_LONGEST_PATH = 12  # Longer ones lose their middle.


def esc(text: object) -> str:
    """Text that can stand anywhere in HTML, attributes included."""
    return _html.escape(str(text), quote=True)


def row(n: int, kind: str = "") -> str:
    """Puts the next n controls beside one another; see static/dashboard.css."""
    return f'<span class="ao-row ao-row-{n} {kind}"></span>'


def no_tab() -> str:
    """Hides the tab of the panel that this stands in; see static/dashboard.css."""
    return '<span class="ao-no-tab"></span>'


def dialog() -> str:
    """Makes the dialog that this stands in wide; see static/dashboard.css."""
    return '<span class="ao-dialog"></span>'


def notice(text: str, *, is_error: bool = False) -> str:
    """A paragraph in place of content."""
    kind = "ao-error" if is_error else "ao-dim"
    return f'<div class="ao ao-decision"><p class="{kind}">{esc(text)}</p></div>'


def faithful(told: Faithfulness | None, *, is_learning: bool = False) -> str:
    """How often such explanations agree with the agent; while it learns, when that is counted."""
    if told is not None:
        words = tell_faithfulness(told)
    elif is_learning:
        words = "Faithfulness is counted when the run is held: until then the agent changes."
    else:
        return ""
    return f'<div class="ao"><p class="ao-dim">{esc(words)}</p></div>'


def supposing() -> str:
    """Stands over what was recorded while the forest shows something else."""
    return (
        '<div class="ao"><p class="ao-supposed">The forest shows a what-if, not this moment; '
        "Reset under What if ends it.</p></div>"
    )


def decision(shown: Decision, spec: TaskSpec, view: ForestView | None) -> str:
    """What was done and why."""
    said = explain(shown, spec, view)
    marks = "".join(f'<span class="ao-mark">{esc(m)}</span>' for m in said.marks)
    color = colors_of(spec)[shown.action]
    return (
        f'<div class="ao ao-decision"><h3><span class="ao-swatch" style="background:{color}">'
        f"</span>{esc(said.headline)}</h3>{marks}<p>{esc(said.reason)}</p></div>"
    )


def path(shown: Decision, spec: TaskSpec, view: ForestView | None) -> str:
    """The path to the most similar option as a stack, root on top, the action at the end."""
    steps = path_steps(shown, spec, view)
    if not steps:
        return ""
    colors = colors_of(spec)
    items = []
    hidden = len(steps) - _LONGEST_PATH
    for i, step in enumerate(steps):
        if hidden > 0 and _LONGEST_PATH // 2 <= i < _LONGEST_PATH // 2 + hidden:
            if i == _LONGEST_PATH // 2:
                items.append(f"<li class='ao-gone'>{count(hidden, 'option')} between</li>")
            continue
        items.append(_path_item(step, i, colors, view))
    last = f'<li class="ao-end" style="--ao-dot:{colors[shown.action]}">'
    items.append(f"{last}<b>{esc(spec.action_names[shown.action])}</b></li>")
    return (
        f'<div class="ao"><h4>Path to the most similar option</h4>'
        f'<ul class="ao-path">{"".join(items)}</ul>{_runner_up(shown)}</div>'
    )


def _path_item(step: PathStep, i: int, colors: list[str], view: ForestView | None) -> str:
    word = "root" if i == 0 else "option"
    is_known = view is not None and 0 <= step.option < len(view.parents)
    if not is_known or view is None or not view.is_alive[step.option]:
        return (
            f'<li class="ao-gone">{word} {step.option} <span class="ao-num">distance '
            f"{number(step.distance)}</span><br>cleansed since</li>"
        )
    gaps = "".join(
        f'<div class="ao-between"><span>{esc(g.feature)}</span><span class="ao-num">'
        f"{esc(g.known)}{_share(g.share)}</span></div>"
        for g in step.gaps[:_SHOWN_GAPS]
    )
    return (
        f'<li style="--ao-dot:{_dot(step.option, colors, view)}"><div class="ao-between"><span>'
        f'{word} <b>{step.option}</b></span><span class="ao-num ao-dim">distance '
        f'{number(step.distance)}</span></div><div class="ao-gaps">{gaps}</div></li>'
    )


def _runner_up(shown: Decision) -> str:
    if shown.runner_up_option == NO_OPTION:
        return ""
    return (
        f'<p class="ao-gaps" style="margin-top:8px">Second most similar: option '
        f"{shown.runner_up_option}, distance {number(shown.runner_up_distance)}.</p>"
    )


def _share(share: float) -> str:
    return "" if np.isnan(share) else f" · {percent(share)}"


def option(
    chosen: int,
    view: ForestView,
    spec: TaskSpec,
    observation: NDArray[np.float64] | None,
    *,
    is_brief: bool = False,
) -> str:
    """An option's value beside what is seen now, unless brief, and what it expects of actions."""
    depth = int(view.depths[chosen])
    born = int(view.born[chosen])
    facts = [f"depth {depth}" if depth else "a root", f"made at step {born:,}"]
    now = [""] * spec.n_features
    if observation is not None:
        now = amounts(observation, spec)
        distance = np.abs(view.attention * (observation - view.values[chosen])).sum()
        facts.append(f"distance now {number(float(distance))}")
    rows = "".join(
        f'<tr><td>{esc(f.name)}</td><td class="ao-num">{esc(v)}</td>'
        f'<td class="ao-num ao-dim">{esc(n)}</td></tr>'
        for f, v, n in zip(spec.features, amounts(view.values[chosen], spec), now, strict=True)
    )
    head = "" if observation is None else "now"
    table = f"<table><tr><th>stands for</th><th>value</th><th>{head}</th></tr>{rows}</table>"
    return (
        f'<div class="ao"><h3>Option {chosen}</h3><p class="ao-dim">{" · ".join(facts)}</p>'
        f"{'' if is_brief else table}"
        f"<h4>Actions: expected return, visits</h4>{_action_bars(chosen, view, spec)}</div>"
    )


def _action_bars(chosen: int, view: ForestView, spec: TaskSpec) -> str:
    weights, visits = view.weights[chosen], view.visits[chosen]
    low, high = float(weights.min()), float(weights.max())
    best = view.best_action_of(chosen)
    bars = []
    told = told_apart(*weights.tolist())
    for i, color in enumerate(colors_of(spec)):
        # Bars compare the actions: the worst still shows a little, the best fills the row.
        width = 100.0 if high == low else 8 + 92 * (float(weights[i]) - low) / (high - low)
        is_best = i == best and visits.any()
        name = f"<b>{esc(spec.action_names[i])}</b>" if is_best else esc(spec.action_names[i])
        tries = count(int(visits[i]), "visit") if visits[i] else "never tried"
        bars.append(
            f'<div class="ao-between"><span>{name}</span><span class="ao-num">'
            f'{told[i]} <span class="ao-dim">· {tries}</span></span></div>'
            f'<span class="ao-bar"><span style="width:{width:.0f}%;background:{color}">'
            "</span></span>"
        )
    return "".join(bars)


def related(chosen: int, view: ForestView, spec: TaskSpec) -> str:
    """The words of a button that leads to an option."""
    best = view.best_action_of(chosen)
    if not view.visits[chosen].any():
        return f"{chosen} · has tried nothing"
    return f"{chosen} · {spec.action_names[best]} {number(float(view.weights[chosen, best]))}"


def _dot(option: int, colors: list[str], view: ForestView) -> str:
    if not view.visits[option].any():
        return to_css(DARK.untried, LIGHT.untried)
    return colors[view.best_action_of(option)]


def colors_of(spec: TaskSpec) -> list[str]:
    """The colour of each action, on dark and on light pages."""
    is_ordered = spec.action_grid is not None
    dark, light = (
        action_colors(spec.n_actions, is_ordered=is_ordered, palette=palette)
        for palette in (DARK, LIGHT)
    )
    return [to_css(*both) for both in zip(dark, light, strict=True)]
