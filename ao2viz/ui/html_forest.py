"""What stands beside the canvas in HTML: the legend. Escaping as in `html`."""

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import count
from ao2viz.figures.coloring import MOST_COMPARED, NEIGHBOURS, Coloring
from ao2viz.figures.palette import DARK, LIGHT, to_css
from ao2viz.ui.detail import Detail
from ao2viz.ui.html import colors_of, esc
from ao2viz.ui.look import Arrangement, Look
from ao2viz.ui.picture import Picture

GREY = "has tried nothing yet"
"""What an option without a colour tells."""

_COMING = "No forest yet: it is on its way."
_ACTIVE = "the schemas that the path and the selected option belong to"
_NO_FOREST = "No forest yet. Start grows one; Watch or the Library opens one."
_MOST_SWATCHES = 9
_LINE_PX = 17.5
_AROUND_PX = 74.0  # The bar above, the buttons and the padding.
_WIDTH_PX = 230.0
_RAMP_PX = 32.0  # Of the colours and what stands below them.
_LETTERS = 32  # In a line.

_TOLD: dict[Coloring, str] = {
    Coloring.VALUE: "expected return, by rank",
    Coloring.VISITS: "how often it was visited",
    Coloring.AGE: "when it was made",
    Coloring.AGREEMENT: f"how many of its {NEIGHBOURS} nearest prefer the same action",
}


def legend(
    spec: TaskSpec | None,
    view: ForestView | None,
    look: Look,
    picture: Picture | None,
    grey: str = GREY,
    left_out: int = 0,
    is_coming: bool = False,
) -> str:
    """What the colours, sizes and lines of the canvas mean.

    `grey` is what that colour tells; for so many options of the active schemas, `left_out`, there
    was no room. Where there is no forest, `is_coming` tells that nobody has to do anything for it.
    """
    if spec is None or view is None:
        return f'<div class="ao-legend">{_COMING if is_coming else _NO_FOREST}</div>'
    if picture is None:
        words = f"Arranging {count(len(view), 'option')} …"
        return f'<div class="ao-legend ao-dim">{words}</div>'
    rows = _rows(spec, view, look, picture, grey, left_out)
    return f'<div class="ao-legend">{"".join(rows)}</div>'


def legend_size(
    spec: TaskSpec | None, view: ForestView | None, look: Look, picture: Picture | None
) -> tuple[float, float]:
    """Width and height in pixels of the panel with the legend, rather too big than too small."""
    if spec is None or view is None or picture is None:
        return _WIDTH_PX, _AROUND_PX + _LINE_PX
    height = _AROUND_PX + _LINE_PX * len(_rows(spec, view, look, picture, GREY, 1))
    if look.coloring is not Coloring.ACTION:
        height += _RAMP_PX + _LINE_PX * (len(_told(look)) // _LETTERS)
    return _WIDTH_PX, height


def _rows(
    spec: TaskSpec,
    view: ForestView,
    look: Look,
    picture: Picture,
    grey: str,
    left_out: int,
) -> list[str]:
    roots = int(((view.parents == NO_OPTION) & view.is_alive).sum())
    rows = [
        f"<b>{esc(spec.title)}</b>",
        f'<div class="ao-dim">{count(len(view), "option")} in {count(roots, "schema")}'
        f"{_place_word(look, roots)}</div>",
    ]
    if picture.n_hidden:
        rows.append(f'<div class="ao-warn">{count(picture.n_hidden, "option")} hidden</div>')
    rows += _detail_rows(picture, left_out)
    rows += _color_rows(spec, look, picture, grey)
    if look.coloring is Coloring.AGREEMENT and len(view) > MOST_COMPARED:
        rows.append(f'<div class="ao-warn">not told above {MOST_COMPARED:,} options</div>')
    if view.visits.any():
        rows.append('<div class="ao-dim">bigger: visited more often</div>')
    if look.arrangement is Arrangement.CONES:
        rows.append('<div class="ao-dim">higher: nearer to its root</div>')
    if len(picture.folded) and picture.detail is not Detail.ROOTS:
        rows.append('<div class="ao-dim">biggest: a root that stands for its schema</div>')
    rows.append(_key("path", "path to the most similar option"))
    if look.arrangement is Arrangement.STATE_SPACE:
        rows.append(_key("now", "state now, and the way there"))
    rows.append(_key("ahead", "its expected way (thin: later)"))
    rows.append(_key("vote", "paths of other voters, by share"))
    rows.append(_key("ring", "selected (click any option)"))
    return rows


def _detail_rows(picture: Picture, left_out: int) -> list[str]:
    """What is not drawn, or not in full, because there is too much of it."""
    match picture.detail:
        case Detail.FULL:
            return []
        case Detail.DOTS:
            rows = ['<div class="ao-warn">so many are dots of one size</div>']
        case Detail.ROOTS:
            rows = [
                '<div class="ao-warn">too many to draw: roots only</div>',
            ]
    rows.append(f'<div class="ao-dim" title="{_ACTIVE}">in full: the active schemas</div>')
    if left_out:
        rows.append(f'<div class="ao-dim">but {left_out:,} of their options</div>')
    return rows


def _place_word(look: Look, roots: int) -> str:
    words = {Arrangement.DISCS: ("disc", "discs"), Arrangement.CONES: ("cone", "cones")}
    if look.arrangement not in words:
        return ""
    return f" ({words[look.arrangement][int(roots != 1)]})"


def _color_rows(spec: TaskSpec, look: Look, picture: Picture, told: str) -> list[str]:
    grey = _swatch(to_css(DARK.untried, LIGHT.untried), told)
    marks = picture.shades.marks
    if marks is None:
        named = list(zip(colors_of(spec), spec.action_names, strict=True))
        rows = [_swatch(c, f"prefers {name}") for c, name in named[:_MOST_SWATCHES]]
        if len(named) > _MOST_SWATCHES:
            rows.append(f'<div class="ao-dim">and {len(named) - _MOST_SWATCHES} more</div>')
        return [*rows, grey]
    stops = ", ".join(to_css(*both) for both in zip(DARK.ramp, LIGHT.ramp, strict=True))
    said = "".join(f"<span>{esc(mark)}</span>" for mark in marks)
    ramp = (
        f"<div>{esc(_told(look))}</div>"
        f'<span class="ao-ramp" style="background:linear-gradient(to right, {stops})"></span>'
        f'<div class="ao-between">{said}</div>'
    )
    return [ramp] if look.coloring is Coloring.AGE else [ramp, grey]


def _told(look: Look) -> str:
    return f"colour: {_TOLD[look.coloring]}"


def _swatch(color: str, words: str) -> str:
    return (
        f'<div><span class="ao-swatch" style="background:{color}"></span>'
        f'<span class="ao-cut">{esc(words)}</span></div>'
    )


def _key(kind: str, words: str) -> str:
    return f'<div><span class="ao-key ao-key-{kind}"></span>{esc(words)}</div>'
