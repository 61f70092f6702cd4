"""One page that explains an agent: opens from disk, loads nothing, needs no server."""

import base64
import hashlib
import json
from importlib import metadata
from typing import IO, Any

import jinja2
import numpy as np
from markupsafe import Markup

from ao2viz.core.config import config_to_dict
from ao2viz.explain.agreement import tell_faithfulness
from ao2viz.explain.sentence import path_steps
from ao2viz.explain.words import amounts, count, number, percent, say_outcome, told_apart
from ao2viz.exports.content import Content, Numbered, Step
from ao2viz.exports.pages import summary_rows
from ao2viz.figures.charts import margins_figure, options_figure, returns_figure
from ao2viz.figures.drawing import Drawing, Theme, to_svg
from ao2viz.figures.line_chart import LEFT, RIGHT, draw_lines
from ao2viz.figures.palette import UNTRIED, action_colors, to_hex
from ao2viz.figures.pictures import ForestPicture
from ao2viz.resources import static

MAX_BYTES = 25_000_000
"""A bigger page opens slowly, or not at all."""

_FOREST_WIDTH = 1000.0
_CHART = (560.0, 260.0)
_EPISODE_CHART = (880.0, 210.0)
_SHOWN_GAPS = 2
_KEPT = "\u00a0"  # A space that no line breaks at.
# The page's own colours, so that one drawing suits light and dark.
_PAGE = Theme("none", "currentColor", "currentColor", "#8b95a5", "#ff4ab2")


def write_report(content: Content, stream: IO[bytes]) -> None:
    """The page.

    Raises:
        ValueError: If it would be too big for a browser; says what else there is.
    """
    page = to_page(content).encode()
    if len(page) > MAX_BYTES:
        longest = max((len(episode) for _, episode in content.episodes), default=0)
        raise ValueError(
            f"This report would have {len(page) / 1e6:.0f} MB, and browsers cope with up to "
            f"{MAX_BYTES / 1e6:.0f} MB: it shows {count(len(content.view), 'option')} and "
            f"{count(longest, 'step')}. Choose a shorter episode (--episode), or --format json."
        )
    stream.write(page)


def to_page(content: Content) -> str:
    """The page as text. Whatever is not `Markup` is escaped by the template."""
    folder = static() / "report"
    css, script, template = (
        (folder / name).read_text("utf-8")
        for name in ("report.css", "report.js", "report.html.jinja")
    )
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    return environment.from_string(template).render(
        policy=page_policy(css, script),
        css=Markup(css),
        script=Markup(script),
        version=metadata.version("ao2viz"),
        **_describe(content),
        **_episode(content),
    )


def page_policy(css: str, script: str = "") -> str:
    """What a page may do: run this script, if any, and this style, and load nothing."""
    running = f"script-src '{_hash(script)}'; " if script else ""
    return (
        f"default-src 'none'; style-src '{_hash(css)}'; {running}base-uri 'none'; "
        f"form-action 'none'"
    )


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def _describe(content: Content) -> dict[str, Any]:
    saved, spec, view = content.saved, content.spec, content.view
    charts = []
    if len(saved.history):
        for caption, figure in (
            ("Return of each training episode", returns_figure(saved.history, spec)),
            ("Options at the end of each training episode", options_figure(saved.history)),
        ):
            charts.append(
                (caption, Markup(to_svg(draw_lines(figure, caption, *_CHART), is_inline=True)))
            )
    return {
        "title": f"{spec.title}: how the agent decides",
        "subtitle": f"An AO2 agent on {spec.env_id}. Every decision is a path through its forest.",
        "summary": [
            (name, value) for name, value in summary_rows(content) if name != "environment"
        ],
        "charts": charts,
        "faithfulness": tell_faithfulness(content.faithfulness),
        "attention": [
            (f.name, f.unit or "a plain number", number(float(w)))
            for f, w in zip(spec.features, view.attention, strict=True)
        ],
        "settings": [(name, str(value)) for name, value in config_to_dict(saved.config).items()],
    }


def _episode(content: Content) -> dict[str, Any]:
    """The forest, and every step of the chosen episode where there is one."""
    spec, view = content.spec, content.view
    colors = [
        to_hex(c) for c in action_colors(spec.n_actions, is_ordered=spec.action_grid is not None)
    ]
    numbered = content.episodes[-1] if content.episodes else None
    decisions = () if numbered is None else numbered.episode.decisions
    visited = np.unique(np.concatenate([np.empty(0, np.int64), *(d.path for d in decisions)]))
    picture = ForestPicture(view, spec, _FOREST_WIDTH, visited, tallest=_FOREST_WIDTH)
    drawing = Drawing(
        _FOREST_WIDTH,
        picture.height,
        tuple(picture.shapes(_PAGE)),
        f"The forest: {picture.caption}",
        "none",
    )
    svg = to_svg(drawing, is_inline=True).removesuffix("</svg>")
    legend = [(c, f"prefers {name}") for c, name in zip(colors, spec.action_names, strict=True)][
        :12
    ]
    if picture.shows_untried:
        legend.append((to_hex(UNTRIED), "has tried nothing yet"))
    shown = {
        "forest": Markup(f'{svg}<g id="forest-path"></g></svg>'),
        "forest_caption": picture.caption,
        "legend": legend,
        "steps": [],
    }
    if numbered is None:
        return shown
    places = {
        option: picture.positions[option].round(1).tolist()
        for option in visited.tolist()
        if option < len(picture.positions) and np.isfinite(picture.positions[option, 0])
    }
    return shown | _steps(content, numbered, colors, places, max(4.0, 0.55 * picture.unit))


def _steps(
    content: Content,
    numbered: Numbered,
    colors: list[str],
    places: dict[int, list[float]],
    ring: float,
) -> dict[str, Any]:
    spec, episode = content.spec, numbered.episode
    rows, steps = [], []
    for step in content.steps(numbered):
        rows.append(_row(step))
        steps.append(_step(step, content))
        content.progress((step.number + 1) / len(episode))
    width, height = _EPISODE_CHART
    figure = margins_figure(np.array([d.margin for d in episode.decisions]))
    caption = "Margin: how much more the chosen action was expected to earn than the next best"
    chart = to_svg(draw_lines(figure, caption, width, height), is_inline=True)
    cursor = f'<line id="cursor" y1="20" y2="{height - 40:g}"/>'
    data = {
        "actions": list(spec.action_names),
        "features": [f.name for f in spec.features],
        "colors": colors,
        "places": places,
        "ring": ring,
        "chart": {"left": LEFT, "width": width - LEFT - RIGHT},
        "steps": steps,
    }
    return {
        "episode_title": f"Episode {numbered.number}, step by step",
        "episode_line": f"Seed {episode.seed}: {say_outcome(episode)}.",
        "steps": rows,
        "margin_caption": f"{caption}. A click goes there.",
        "margins": Markup(f"{chart.removesuffix('</svg>')}{cursor}</svg>"),
        # "<" could end the element that holds the data.
        "data": Markup(json.dumps(data, allow_nan=False).replace("<", "\\u003c")),
    }


def _row(step: Step) -> dict[str, str]:
    """A step as it stands in the table of all of them."""
    return {
        "headline": step.said.headline,
        "path": " → ".join(str(option) for option in step.decision.path.tolist()),
        "reason": step.said.reason,
        "reward": number(step.reward),
    }


def _step(step: Step, content: Content) -> dict[str, Any]:
    """A step as the page's script shows it; short keys, as there are many."""
    decision = step.decision
    path = []
    for element in path_steps(decision, content.spec, content.view):
        gaps = []
        for gap in element.gaps[:_SHOWN_GAPS]:
            share = "" if np.isnan(gap.share) else f" · {percent(gap.share)}".replace(" ", _KEPT)
            gaps.append(f"{gap.feature}: {gap.known} there, {gap.seen} now{share}")
        path.append([element.option, number(element.distance), gaps])
    return {
        "a": decision.action,
        "s": step.said.reason,
        "k": list(step.said.marks),
        "w": [
            [option, percent(share), int(np.argmax(weights))]
            for option, share, weights in zip(
                decision.voters.tolist(),
                decision.shares.tolist(),
                decision.voter_weights,
                strict=True,
            )
            if share > 0
        ],
        "p": path,
        "v": told_apart(*decision.action_values.tolist(), digits=4),
        "n": decision.action_values.tolist(),
        "o": amounts(decision.observation, content.spec),
    }
