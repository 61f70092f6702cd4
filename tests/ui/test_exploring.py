"""What people choose about the forest: arrangement, colours, folding, and finding an option."""

import numpy as np
import pytest

from ao2viz.core.decision import NO_OPTION
from ao2viz.figures.coloring import Coloring
from ao2viz.ui.commands import (
    ChooseArrangement,
    ChooseAxis,
    ChooseColoring,
    FindState,
    FocusSelection,
    Fold,
    FoldAll,
    LimitDepth,
    Select,
    SelectDecided,
    Walk,
    Way,
)
from ao2viz.ui.exploring import choose_axes, explore
from ao2viz.ui.look import Arrangement, Look
from ao2viz.ui.session import Session
from ao2viz.ui.typed import read_state
from tests.forests import cartpole, decision, pendulum, random_view, small_view

SPEC = cartpole()


def after(session: Session, *commands) -> Session:
    for command in commands:
        session, problem = explore(session, command, small_view(), SPEC, decision())
        assert problem == ""
    return session


def problem_of(session: Session, command) -> str:
    changed, problem = explore(session, command, small_view(), SPEC, decision())
    assert changed == session
    return problem


def test_the_next_arrangement_and_colour_come_in_turn_and_around():
    session = Session()
    for expected in (*list(Arrangement)[1:], Arrangement.DISCS):
        before = session.fits
        session = after(session, ChooseArrangement(None))
        assert session.look.arrangement is expected
        assert session.fits == before + 1
    for expected in (*list(Coloring)[1:], Coloring.ACTION):
        session = after(session, ChooseColoring(None))
        assert session.look.coloring is expected


def test_axes_begin_with_what_distance_rests_on_most():
    look = Look(arrangement=Arrangement.STATE_SPACE)
    view = small_view()
    spread = view.attention * view.values.std(axis=0)
    chosen = choose_axes(look, view)
    assert set(chosen.axes) == set(np.argsort(-spread)[:2].tolist())
    assert choose_axes(chosen, random_view(20)) is chosen
    assert choose_axes(look, None) is look


@pytest.mark.parametrize(
    ("axes", "place", "feature", "expected"),
    [
        ((0, 1), 0, 2, (2, 1)),
        ((0, 1), 0, 1, (1, 0)),
        ((0, 1), 2, 3, (0, 1, 3)),
        ((0, 1), 2, 1, (0, 2, 1)),
        ((0, 1, 2), 2, None, (0, 1)),
        ((0, 1, 2), 1, 0, (1, 0, 2)),
        ((0, 1), 0, None, (0, 1)),
    ],
)
def test_an_axis_takes_a_feature_and_none_is_used_twice(axes, place, feature, expected):
    session = after(Session(look=Look(axes=axes)), ChooseAxis(place, feature))
    assert session.look.axes == expected


def test_axes_that_a_task_does_not_have_are_ignored():
    assert Look(axes=(0, 9, 0)).axes_for(4) == (0, 1)
    assert Look(axes=(3, 1, 2)).axes_for(4) == (3, 1, 2)
    assert Look().axes_for(1) == (0,)


def test_a_schema_is_folded_by_any_of_its_options():
    session = after(Session(selected=4), Fold())
    assert session.look.folded == {0}
    assert after(session, Fold()).look.folded == frozenset()
    assert after(session, FoldAll(True)).look.folded == {0, 3}
    assert after(session, FoldAll(True), FoldAll(False)).look.folded == frozenset()
    assert "Select" in problem_of(Session(), Fold())
    assert after(session, LimitDepth(1)).look.deepest == 1


def test_the_forest_is_walked_by_key():
    walked = after(Session(), Walk(Way.PARENT))
    assert walked.selected == 0  # Nothing was selected: the first root.
    walked = after(walked, Walk(Way.CHILD))
    assert walked.selected == 1  # Visited more often than its sibling 2.
    assert after(walked, Walk(Way.AFTER)).selected == 2
    assert after(walked, Walk(Way.AFTER), Walk(Way.AFTER)).selected == 1
    assert after(walked, Walk(Way.BEFORE)).selected == 2
    assert after(walked, Walk(Way.CHILD)).selected == 4
    assert after(walked, Walk(Way.CHILD), Walk(Way.CHILD)).selected == 4
    assert after(walked, Walk(Way.PARENT)).selected == 0
    assert after(walked, Walk(Way.PARENT), Walk(Way.AFTER)).selected == 3


def test_an_option_is_selected_by_id_by_decision_or_not_at_all():
    assert after(Session(), Select(3)).selected == 3
    assert after(Session(), SelectDecided()).selected == 4
    assert after(Session(selected=3), Select(NO_OPTION)).selected == NO_OPTION
    assert "99" in problem_of(Session(selected=3), Select(99))
    assert "Select an option" in problem_of(Session(), FocusSelection())
    assert after(Session(selected=3), FocusSelection()).selection_focuses == 1
    assert "no forest" in explore(Session(), Select(0), None, None, None)[1].lower()


def test_the_option_nearest_to_a_typed_state_is_selected():
    # Radians inside, degrees for people: 3.4° is option 4's pole angle, near enough.
    assert after(Session(), FindState("0.1, 0.2, 3.4, 0")).selected == 4
    assert after(Session(), FindState("−0.1 m; 0 m/s; −2.9°; 0°/s")).selected == 2
    assert after(Session(selected=1), FindState("  ")).selected == 1


@pytest.mark.parametrize(
    "text", ["1, 2, 3", "a, b, c, d", "1 2 3 4 5", "1, 2, 3, 1e999", "nan " * 4]
)
def test_what_is_no_state_is_told_in_words(text):
    assert "xpected" in problem_of(Session(), FindState(text))


def test_a_typed_state_is_read_in_the_units_that_people_see():
    state = read_state("1, 0, −57.29577951308232 °/s", pendulum())
    np.testing.assert_allclose(state, [1, 0, -1])
    with pytest.raises(ValueError, match="height"):
        read_state("1", pendulum())
