"""The forest and a path as drawings: what the dashboard shows, for pages, papers and films."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.sentence import explain, path_steps
from ao2viz.explain.words import count, number, percent
from ao2viz.figures.drawing import (
    LIGHT,
    Box,
    Dots,
    Drawing,
    Polyline,
    Ring,
    Segments,
    Shape,
    Text,
    Theme,
)
from ao2viz.figures.palette import UNTRIED, action_colors, to_hex
from ao2viz.figures.raster import shorten, text_width, wrap
from ao2viz.layout.discs import lay_out

MAX_DRAWN = 20_000
"""Options; of a bigger forest the most visited are drawn, and all that a path needs."""

_SHOWN_STEPS = 9  # Of a path; a longer one loses its middle.
_WHOLE = " of the distance"  # Said of a share where there is room for it.
_LINE = 1.45  # Height of a line of text, in letter sizes.


class ForestPicture:
    """Where every option of a forest is drawn, in pixels of a field `width` wide."""

    def __init__(
        self,
        view: ForestView,
        spec: TaskSpec,
        width: float,
        needed: NDArray[np.int64] | None = None,
        tallest: float = np.inf,
    ) -> None:
        """Lays the forest out.

        Args:
            view: The forest.
            spec: Its task.
            width: Of the field.
            needed: Ids that must be drawn in any case, because paths lead there.
            tallest: Height of the field at most.
        """
        self._view, self._spec = view, spec
        positions = lay_out(view).positions
        self.drawn = _choose(view, np.empty(0, np.int64) if needed is None else needed)
        self.positions = np.full((len(view.parents), 2), np.nan)
        self.unit, self.height = 1.0, 40.0
        if len(self.drawn) == 0:
            return
        low, high = positions[self.drawn].min(axis=0), positions[self.drawn].max(axis=0)
        size = high - low + 2.0
        self.unit = float(min(width / size[0], tallest / size[1], 24.0))
        self.height = float(size[1] * self.unit)
        left = (width - size[0] * self.unit) / 2
        scaled = (positions[self.drawn] - low + 1.0) * self.unit
        self.positions[self.drawn, 0] = left + scaled[:, 0]
        self.positions[self.drawn, 1] = self.height - scaled[:, 1]

    def shapes(self, theme: Theme) -> list[Shape]:
        """Edges and options."""
        view, drawn = self._view, self.drawn
        parents = view.parents[drawn]
        has_edge = (parents != NO_OPTION) & ~np.isnan(self.positions[parents, 0])
        ends = np.stack(
            [self.positions[parents[has_edge]], self.positions[drawn[has_edge]]], axis=1
        )
        visits = view.visits[drawn].sum(axis=1)
        colors = action_colors(self._spec.n_actions, is_ordered=self._spec.action_grid is not None)
        chosen = np.where(
            visits[:, None] > 0, colors[view.best_actions[drawn]], np.array(UNTRIED, np.uint8)
        )
        radii = np.clip(0.24 + 0.045 * np.log2(1 + visits), 0, 0.46) * self.unit
        return [
            Segments(ends, theme.edge, max(0.4, 0.07 * self.unit), 0.7),
            Dots(self.positions[drawn], radii, chosen.astype(np.uint8)),
        ]

    def path_shapes(self, path: NDArray[np.int64], theme: Theme, size: float) -> list[Shape]:
        """The path from root to option, with the ids of its ends."""
        # A decision may be older than the forest: what was cleansed since cannot be drawn.
        known = path[(path < len(self.positions))]
        known = known[~np.isnan(self.positions[known, 0])]
        if len(known) == 0:
            return []
        places = self.positions[known]
        ring = max(3.5, 0.55 * self.unit)
        shapes: list[Shape] = [Polyline(places, theme.path, max(2.0, 0.16 * self.unit))]
        shapes += [Ring((x, y), ring, theme.path, 2.0) for x, y in places.tolist()]
        # Each id stands on the side that leads away from the other end, so they stay apart.
        goes_right = bool(places[-1, 0] >= places[0, 0])
        ends = [(0, not goes_right), (-1, goes_right)] if len(known) > 1 else [(0, True)]
        for end, is_right in ends:
            x, y = places[end].tolist()
            at = x + ring + 4 if is_right else x - ring - 4
            anchor = "start" if is_right else "end"
            shapes.append(Text(at, y - ring, str(known[end]), size, theme.path, True, anchor))
        return shapes

    @property
    def shows_untried(self) -> bool:
        """Whether an option is drawn that has tried no action yet."""
        return bool((self._view.visits[self.drawn].sum(axis=1) == 0).any())

    @property
    def caption(self) -> str:
        """How much of the forest is drawn."""
        held = len(self._view)
        if len(self.drawn) == held:
            return f"{count(held, 'option')}; the bigger, the more often visited"
        return f"the {count(len(self.drawn), 'option')} most visited of {held:,}"


def draw_forest(
    view: ForestView,
    spec: TaskSpec,
    decision: Decision | None = None,
    width: float = 1200.0,
    theme: Theme = LIGHT,
    note: str = "",
) -> Drawing:
    """The whole forest with a legend, and the path of a decision if one is given, with a note."""
    path = np.empty(0, np.int64) if decision is None else decision.path
    margin, size = 24.0, 15.0
    picture = ForestPicture(view, spec, width - 2 * margin, path, tallest=1.2 * width)
    heading = [Text(margin, margin + 18, shorten(spec.title, 22, width - 60), 22, theme.ink, True)]
    lines = [picture.caption]
    if decision is not None:
        lines += wrap(f"{_sentence(decision, spec, view)} {note}", size, width - 2 * margin)
    top = margin + 22
    shapes: list[Shape] = list(heading)
    for line in lines:
        top += size * _LINE
        shapes.append(Text(margin, top, line, size, theme.dim))
    top += 14
    inside = [*picture.shapes(theme), *picture.path_shapes(path, theme, size)]
    shapes += [_moved(shape, margin, top) for shape in inside]
    legend, height = _legend(
        spec, picture.shows_untried, margin, top + picture.height + 26, width - margin, size, theme
    )
    title = f"The forest of {spec.title}: {picture.caption}"
    return Drawing(width, height + margin, (*shapes, *legend), title, theme.paper)


def draw_path(
    decision: Decision,
    spec: TaskSpec,
    view: ForestView,
    width: float = 640.0,
    theme: Theme = LIGHT,
    note: str = "",
) -> Drawing:
    """The path as a stack, the root on top, the action at its end; sentence and note below."""
    margin, size, inner = 20.0, 14.0, width - 40.0
    colors = action_colors(spec.n_actions, is_ordered=spec.action_grid is not None)
    said = explain(decision, spec, view)
    shapes: list[Shape] = []
    y = margin
    steps = path_steps(decision, spec, view)
    hidden = max(0, len(steps) - _SHOWN_STEPS)
    for i, step in enumerate(steps):
        if hidden and 4 <= i < 4 + hidden:
            if i == 4:
                text = f"{count(hidden, 'option')} between"
                shapes.append(Text(margin + 34, y + 16, text, size, theme.dim))
                y += 32
            continue
        gaps = step.gaps[:2]
        height = 36.0 + (6 + len(gaps) * size * _LINE if gaps else 0)
        if i:
            shapes.append(_link(margin + 16, y - 10, y, theme))
        is_last = i == len(steps) - 1
        outline = theme.path if is_last else theme.edge
        shapes.append(Box(margin, y, inner, height, theme.paper, 8, outline))
        shapes.append(_dot(margin + 16, y + 18, _preference(step.option, view, colors)))
        word = "root" if i == 0 else "option"
        shapes.append(Text(margin + 34, y + 23, f"{word} {step.option}", 15, theme.ink, True))
        shapes.append(
            Text(
                width - margin - 12, y + 23, f"distance {number(step.distance)}", size, theme.dim,
                anchor="end",
            )
        )  # fmt: skip
        line = y + 28.0
        for gap in gaps:
            line += size * _LINE
            share = "" if np.isnan(gap.share) else f" · {percent(gap.share)}"
            text = f"{gap.feature}: {gap.known} there, {gap.seen} now{share}"
            if share and text_width(f"{text}{_WHOLE}", size) <= inner - 46:
                text += _WHOLE
            shapes.append(Text(margin + 34, line, shorten(text, size, inner - 46), size, theme.dim))
        y += height + 10
    if steps:
        shapes.append(_link(margin + 16, y - 10, y, theme))
    shapes.append(Box(margin, y, inner, 40, theme.paper, 8, to_hex(colors[decision.action])))
    shapes.append(_dot(margin + 16, y + 20, colors[decision.action]))
    name = shorten(said.headline, 16, inner - 200)
    shapes.append(Text(margin + 34, y + 26, name, 16, theme.ink, True))
    marks = ", ".join(said.marks)
    if marks:
        at = margin + 34 + text_width(name, 16, is_bold=True) + 14
        room = width - margin - 12 - at
        shapes.append(Text(at, y + 26, shorten(marks, size, room), size, theme.dim))
    y += 40 + 8
    for line in wrap(said.reason, size, inner):
        y += size * _LINE
        shapes.append(Text(margin, y, line, size, theme.ink))
    for line in wrap(note, size, inner):
        y += size * _LINE
        shapes.append(Text(margin, y, line, size, theme.dim))
    title = f"{said.headline}. {said.reason}"
    return Drawing(width, y + margin, tuple(shapes), title, theme.paper)


def _sentence(decision: Decision, spec: TaskSpec, view: ForestView) -> str:
    said = explain(decision, spec, view)
    return f"{said.headline[:1].upper()}{said.headline[1:]}. {said.reason}"


def _choose(view: ForestView, needed: NDArray[np.int64]) -> NDArray[np.int64]:
    alive = np.flatnonzero(view.is_alive)
    if len(alive) <= MAX_DRAWN:
        return alive
    visits = view.visits[alive].sum(axis=1)
    often = alive[np.argsort(-visits, kind="stable")[:MAX_DRAWN]]
    inside = needed[(needed >= 0) & (needed < len(view.parents))]
    return np.union1d(often, inside[view.is_alive[inside]])


def _legend(
    spec: TaskSpec,
    with_untried: bool,
    x: float,
    y: float,
    right: float,
    size: float,
    theme: Theme,
) -> tuple[list[Shape], float]:
    """What the colours mean, in as many rows as needed; and where the last row ends."""
    colors = action_colors(spec.n_actions, is_ordered=spec.action_grid is not None)
    entries = [*zip(colors, (f"prefers {name}" for name in spec.action_names), strict=True)][:12]
    if with_untried:
        entries.append((np.array(UNTRIED, np.uint8), "has tried nothing yet"))
    shapes: list[Shape] = []
    at = x
    for color, words in entries:
        text = shorten(words, size, right - x - 20)
        wide = 20 + text_width(text, size) + 24
        if at > x and at + wide > right:
            at, y = x, y + size * 1.7
        shapes += [_dot(at + 6, y - 5, color), Text(at + 18, y, text, size, theme.ink)]
        at += wide
    return shapes, y


def _preference(option: int, view: ForestView, colors: NDArray[np.uint8]) -> NDArray[np.uint8]:
    is_known = 0 <= option < len(view.parents) and view.is_alive[option]
    if not is_known or not view.visits[option].any():
        return np.array(UNTRIED, np.uint8)
    return colors[view.best_action_of(option)]


def _dot(x: float, y: float, color: NDArray[np.uint8]) -> Dots:
    return Dots(np.array([[x, y]]), np.array([6.0]), np.asarray(color, np.uint8)[None])


def _link(x: float, top: float, bottom: float, theme: Theme) -> Segments:
    return Segments(np.array([[[x, top], [x, bottom]]]), theme.path, 2.0)


def _moved(shape: Shape, x: float, y: float) -> Shape:
    """The shape, shifted."""
    by = np.array([x, y])
    match shape:
        case Segments():
            return replace(shape, ends=shape.ends + by)
        case Dots():
            return replace(shape, centres=shape.centres + by)
        case Polyline():
            return replace(shape, points=shape.points + by)
        case Ring():
            return replace(shape, centre=(shape.centre[0] + x, shape.centre[1] + y))
        case Text() | Box():
            return replace(shape, x=shape.x + x, y=shape.y + y)
