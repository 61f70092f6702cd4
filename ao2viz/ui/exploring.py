"""What commands about the forest on the canvas change in a session; pure.

These are the cases of `reduce` that choose how the forest is shown and which option is selected.
"""

from dataclasses import replace
from typing import TypeVar, assert_never

import numpy as np

from ao2viz.core.decision import NO_OPTION, Decision
from ao2viz.core.forest import ForestView
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import number
from ao2viz.figures.coloring import Coloring
from ao2viz.layout.discs import schemas_of
from ao2viz.ui.commands import (
    ChooseArrangement,
    ChooseAxis,
    ChooseColoring,
    FindState,
    Fit,
    FocusPath,
    FocusSelection,
    Fold,
    FoldAll,
    GoBack,
    GoForward,
    LimitDepth,
    OpenWeight,
    Select,
    SelectDecided,
    TidyUp,
    Walk,
    Way,
)
from ao2viz.ui.look import Arrangement, Look
from ao2viz.ui.session import Place, Session
from ao2viz.ui.typed import read_state

_T = TypeVar("_T")
_TRAIL = 100  # So many selections are remembered.

Exploring = (
    Select
    | SelectDecided
    | Walk
    | FindState
    | OpenWeight
    | GoBack
    | GoForward
    | Fit
    | FocusPath
    | FocusSelection
    | TidyUp
    | ChooseArrangement
    | ChooseColoring
    | ChooseAxis
    | LimitDepth
    | Fold
    | FoldAll
)
"""The commands that this file knows."""


def explore(
    session: Session,
    command: Exploring,
    forest: ForestView | None,
    spec: TaskSpec | None,
    decision: Decision | None,
) -> tuple[Session, str]:
    """The session after a command, and in words why nothing came of it, if nothing did."""
    match command:
        case Fit():
            return replace(session, fits=session.fits + 1), ""
        case FocusPath():
            return replace(session, focuses=session.focuses + 1), ""
        case FocusSelection():
            if session.selected == NO_OPTION:
                return session, "Select an option first: click one, or type its id."
            return replace(session, selection_focuses=session.selection_focuses + 1), ""
        case TidyUp():
            return replace(session, tidies=session.tidies + 1, fits=session.fits + 1), ""
        case ChooseArrangement() | ChooseColoring() | ChooseAxis() | LimitDepth():
            return _change_look(session, command, spec), ""
    if forest is None or spec is None:
        return session, "There is no forest yet."
    match command:
        case Select(option):
            return _select(session, option, forest)
        case SelectDecided():
            if decision is None or len(decision.path) == 0:
                return session, "No option decided at this moment."
            return _select(session, int(decision.path[-1]), forest)
        case OpenWeight(action):
            return _open_weight(session, action, forest)
        case GoBack():
            return _go(session, -1, forest)
        case GoForward():
            return _go(session, 1, forest)
        case Walk(way):
            return _select(session, _neighbour(session.selected, way, forest), forest)
        case FindState(text):
            return _find_state(session, text, forest, spec)
        case Fold():
            return _fold(session, forest)
        case FoldAll(is_folded):
            roots = np.flatnonzero((forest.parents == NO_OPTION) & forest.is_alive)
            folded = frozenset(roots.tolist()) if is_folded else frozenset[int]()
            return replace(session, look=replace(session.look, folded=folded)), ""
        case _:
            assert_never(command)


def _change_look(
    session: Session,
    command: ChooseArrangement | ChooseColoring | ChooseAxis | LimitDepth,
    spec: TaskSpec | None,
) -> Session:
    look = session.look
    match command:
        case ChooseArrangement(arrangement):
            chosen = arrangement or _next(list(Arrangement), look.arrangement)
            if chosen is look.arrangement:
                return session
            look = replace(look, arrangement=chosen)
            return replace(session, look=look, fits=session.fits + 1)
        case ChooseColoring(coloring):
            chosen = coloring or _next(list(Coloring), look.coloring)
            return replace(session, look=replace(look, coloring=chosen))
        case ChooseAxis(place, feature):
            n_features = spec.n_features if spec is not None else 0
            axes = _with_axis(look.axes_for(n_features), place, feature, n_features)
            return replace(session, look=replace(look, axes=axes), fits=session.fits + 1)
        case LimitDepth(deepest):
            return replace(session, look=replace(look, deepest=deepest))
        case _:
            assert_never(command)


def _with_axis(
    axes: tuple[int, ...], place: int, feature: int | None, n_features: int
) -> tuple[int, ...]:
    """The axes with a feature in its place; where it was before comes one that is not used."""
    changed = list(axes)
    if feature is None:
        return tuple(changed[:place] + changed[place + 1 :]) if place > 1 else axes
    if feature in changed:
        former = changed.index(feature)
        unused = [i for i in range(n_features) if i not in changed]
        other = changed[place] if place < len(changed) else next(iter(unused), None)
        if other is None:
            return axes
        changed[former] = other
    if place >= len(changed):
        return (*changed, feature)
    changed[place] = feature
    return tuple(changed)


def _next(choices: list[_T], current: _T) -> _T:
    return choices[(choices.index(current) + 1) % len(choices)]


def _select(session: Session, option: int, forest: ForestView) -> tuple[Session, str]:
    if option == NO_OPTION:
        return replace(session, selected=NO_OPTION, opened=None), ""
    if option == session.selected:
        return session, ""
    if not 0 <= option < len(forest.parents) or not forest.is_alive[option]:
        return session, f"There is no option {option} here."
    return _visit(session, Place(option)), ""


def _visit(session: Session, place: Place) -> Session:
    """Shows a place and remembers the way there; what was ahead on another way is forgotten."""
    trail = (*session.trail[: session.trail_at + 1], place)[-_TRAIL:]
    return replace(
        session,
        selected=place.option,
        opened=place.action,
        trail=trail,
        trail_at=len(trail) - 1,
    )


def _open_weight(session: Session, action: int | None, forest: ForestView) -> tuple[Session, str]:
    if action == session.opened:
        return session, ""
    if not 0 <= session.selected < len(forest.parents):
        return session, "Select an option first: click one, or type its id."
    if action is not None and not 0 <= action < forest.weights.shape[1]:
        return session, f"There is no action {action}."
    return _visit(session, Place(session.selected, action)), ""


def _go(session: Session, by: int, forest: ForestView) -> tuple[Session, str]:
    at = session.trail_at + by
    if not 0 <= at < len(session.trail):
        return session, ""
    place = session.trail[at]
    session = replace(session, trail_at=at)
    if place.option >= len(forest.parents) or not forest.is_alive[place.option]:
        return session, f"Option {place.option} was cleansed meanwhile."
    return replace(session, selected=place.option, opened=place.action), ""


def _neighbour(selected: int, way: Way, forest: ForestView) -> int:
    """The option that a way leads to; where there is none, the one it began at."""
    roots = np.flatnonzero((forest.parents == NO_OPTION) & forest.is_alive)
    is_known = 0 <= selected < len(forest.parents) and bool(forest.is_alive[selected])
    if not is_known:
        return int(roots[0]) if len(roots) else NO_OPTION
    parent = int(forest.parents[selected])
    match way:
        case Way.PARENT:
            return parent if parent != NO_OPTION else selected
        case Way.CHILD:
            children = forest.children_of(selected)
            if len(children) == 0:
                return selected
            return int(children[np.argmax(forest.visits[children].sum(axis=1))])
        case Way.BEFORE | Way.AFTER:
            siblings = roots if parent == NO_OPTION else forest.children_of(parent)
            at = int(np.searchsorted(siblings, selected)) + (1 if way is Way.AFTER else -1)
            return int(siblings[at % len(siblings)])
        case _:
            assert_never(way)


def _find_state(
    session: Session, text: str, forest: ForestView, spec: TaskSpec
) -> tuple[Session, str]:
    if not text.strip():
        return session, ""
    try:
        state = read_state(text, spec)
    except ValueError as error:
        return session, str(error)
    if len(forest) == 0:
        return session, "There are no options yet."
    return _select(session, int(np.argmin(forest.distances_to(state))), forest)


def say_found(session: Session, text: str, forest: ForestView | None, spec: TaskSpec | None) -> str:
    """Which option stands nearest to a typed state and how near; nothing if none was typed."""
    if not text.strip() or forest is None or spec is None:
        return ""
    away = number(float(forest.distances_to(read_state(text, spec))[session.selected]))
    return f"Option {session.selected} is the nearest, {away} away. Inspect tells of it."


def _fold(session: Session, forest: ForestView) -> tuple[Session, str]:
    if not 0 <= session.selected < len(forest.parents):
        return session, "Select an option of the schema first: click one, or type its id."
    root = int(schemas_of(forest)[session.selected])
    if root == NO_OPTION:
        return session, f"Option {session.selected} was cleansed."
    folded = session.look.folded ^ {root}
    return replace(session, look=replace(session.look, folded=folded)), ""


def choose_axes(look: Look, forest: ForestView | None) -> Look:
    """The look with axes for the state space, unless some were chosen: what distance rests on."""
    if look.arrangement is not Arrangement.STATE_SPACE or look.axes or not forest:
        return look
    weights = forest.attention * forest.values[forest.is_alive].std(axis=0)
    ranked = np.argsort(-weights, kind="stable")[:2]
    return replace(look, axes=tuple(sorted(ranked.tolist())))


def forget_place(look: Look) -> Look:
    """The look for another forest: what was chosen among its options means nothing there."""
    return replace(look, folded=frozenset(), axes=())
