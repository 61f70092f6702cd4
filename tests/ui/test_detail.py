"""Forests too big to be drawn in full: what is drawn of them, what is sent, and what is said."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import viser
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView
from ao2viz.figures.coloring import Coloring
from ao2viz.layout.discs import lay_out
from ao2viz.ui import chunks, detail
from ao2viz.ui.chunks import AT_A_TIME, CHUNK, _Dots
from ao2viz.ui.close_up import WHILE_PLAYING, Focus, active_in, find_close_up
from ao2viz.ui.detail import MOST_DOTS, MOST_SHAPES, Detail, choose_roots, detail_for
from ao2viz.ui.gallery import Gallery
from ao2viz.ui.html_forest import legend
from ao2viz.ui.look import Arrangement, Look
from ao2viz.ui.overlay import Moment, overlay
from ao2viz.ui.picture import Picture, draw
from ao2viz.ui.scene import Canvas, prepare
from ao2viz.ui.security import make_server
from tests.forests import cartpole, decision, first, random_view

SPEC = cartpole()


def big_view(n: int, roots: int = 100) -> ForestView:
    """A wide forest: everything hangs below one of the roots."""
    rng = np.random.default_rng(0)
    parents = np.where(np.arange(n) < roots, NO_OPTION, rng.integers(0, roots, n))
    small = random_view(3)
    return replace(
        small,
        values=rng.normal(size=(n, 4)),
        parents=parents,
        depths=(parents != NO_OPTION).astype(np.int64),
        weights=rng.normal(size=(n, 2)),
        visits=rng.integers(0, 30, (n, 2)),
        born=np.arange(n),
        is_alive=np.ones(n, np.bool_),
        revision=n,
    )


def picture_of(view: ForestView, **look) -> Picture:
    return draw(view, lay_out(view), SPEC, Look(**look))


@pytest.fixture
def few(monkeypatch) -> None:
    """A page that can show 40 shapes and 90 dots."""
    monkeypatch.setattr(detail, "MOST_SHAPES", 40)
    monkeypatch.setattr(detail, "MOST_DOTS", 90)


@pytest.mark.parametrize(
    ("n", "expected"),
    [
        (0, Detail.FULL),
        (MOST_SHAPES, Detail.FULL),
        (MOST_SHAPES + 1, Detail.DOTS),
        (MOST_DOTS, Detail.DOTS),
        (MOST_DOTS + 1, Detail.ROOTS),
    ],
)
def test_how_much_is_drawn_follows_from_how_much_there_is(n, expected):
    assert detail_for(n) is expected


@pytest.mark.parametrize("arrangement", list(Arrangement))
def test_of_a_huge_forest_the_roots_are_drawn_and_nothing_else(few, arrangement):
    view = random_view(200)
    gallery = Gallery()
    look = Look(arrangement=arrangement, axes=(0, 1))
    picture = gallery.get(("file", "a", 0), view, SPEC, look)
    assert picture is not None
    assert picture.detail is Detail.ROOTS
    assert picture.drawn.tolist() == [0, 1, 2]
    assert (picture.drawn_sizes > 1).all()  # They stand for more than themselves.
    assert len(picture.edges) == 0


def test_what_is_not_drawn_is_not_picked_unless_a_close_up_shows_it(few):
    picture = picture_of(random_view(200))
    option = int(np.flatnonzero((picture.schemas == 1) & (picture.depths > 1))[0])
    x, y, _ = picture.positions[option].tolist()
    above = ((x, y, 50.0), (0.0, 0.0, -1.0))
    assert picture.pick(*above) != option
    assert picture.pick(*above, find_close_up(picture, (1,)).options) == option
    assert picture.pick(*above, find_close_up(picture, (2,)).options) != option


def test_folding_and_a_limit_to_depth_bring_full_detail_back(few):
    view = random_view(200)
    assert picture_of(view, deepest=1).detail is not Detail.ROOTS
    folded = picture_of(view, folded=frozenset({0, 1, 2}))
    assert folded.detail is Detail.FULL
    assert np.count_nonzero(folded.sizes) == 3


def test_dots_are_all_there_and_have_no_lines(few):
    picture = picture_of(random_view(70))
    assert picture.detail is Detail.DOTS
    assert len(picture.drawn) == 70
    assert len(picture.edges) == 0


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 1000), most=st.integers(1, 150), schema=st.integers(0, 2))
def test_a_close_up_is_a_whole_tree_from_the_root_down(seed, most, schema):
    picture = picture_of(random_view(150, seed=seed))
    close_up = find_close_up(picture, (schema,), most)
    members = np.flatnonzero(picture.schemas == schema)
    assert len(close_up.options) == min(most, len(members))
    assert close_up.n_left_out == len(members) - len(close_up.options)
    assert set(close_up.options.tolist()) <= set(members.tolist())
    shown = {NO_OPTION}
    for option in close_up.options.tolist():
        assert int(picture.parents[option]) in shown
        shown.add(option)
    assert len(close_up.edges) == len(close_up.options) - 1


def test_there_is_no_close_up_of_what_is_drawn_in_full_anyway(few):
    assert active_in(picture_of(random_view(30)), (4,)) == ()
    big = picture_of(random_view(200))
    assert active_in(big, (NO_OPTION, 999)) == ()
    assert active_in(big, (2, 1, 2)) == (1, 2)


def test_a_close_up_follows_a_replay_a_little_late_and_a_person_at_once(few):
    picture, now = picture_of(random_view(200)), [0.0]
    focus = Focus(lambda: now[0])
    first_one = focus.get(picture, (0,), is_moving=True)
    assert focus.get(picture, (1,), is_moving=True) is first_one
    now[0] = 5.0
    later = focus.get(picture, (1,), is_moving=True)
    assert later is not None
    assert later.roots == (1,)
    held = focus.get(picture, (2,), is_moving=False)
    assert held is not None
    assert held.roots == (2,)
    assert focus.get(picture, (2,), is_moving=False) is held
    assert WHILE_PLAYING < MOST_SHAPES


def test_of_too_many_roots_those_of_the_biggest_schemas_are_drawn(monkeypatch):
    monkeypatch.setattr(detail, "MOST_SHAPES", 2)
    schemas = np.array([0, 1, 2, 0, 2, 2, 0])
    assert choose_roots(np.arange(3), schemas, np.ones(7, np.bool_)).tolist() == [0, 2]


def test_the_legend_says_what_is_left_out(few):
    def said(n: int, left_out: int = 0) -> str:
        view = random_view(n)
        return legend(SPEC, view, Look(), picture_of(view), left_out=left_out)

    assert "active schemas" not in said(30)
    assert "dots of one size" in said(70)
    assert "too many to draw: roots only" in said(200)
    assert "in full: the active schemas" in said(200)
    assert "but 1,234 of their options" in said(200, left_out=1234)
    assert "Arranging 30 options" in legend(SPEC, random_view(30), Look(), None)


class Wired:
    """A canvas, and what goes out to its browser."""

    def __init__(self, server: viser.ViserServer) -> None:
        prepare(server.scene)
        self._buffer = server._websock_server.get_message_buffer()
        self.canvas = Canvas(server)  # pyright: ignore[reportArgumentType]  Only its scene.
        self.messages = self.n_bytes = 0
        push = self._buffer.push

        def count(message) -> None:
            self.messages += 1
            for name, value in vars(message).items():
                parts = value.values() if name == "updates" else [value]
                self.n_bytes += sum(getattr(part, "nbytes", 0) for part in parts)
                self.n_bytes += (
                    sum(getattr(p, "nbytes", 0) for p in vars(value).values())
                    if (name == "props")
                    else 0
                )
            push(message)

        self._buffer.push = count

    def show(self, picture, over=None, close_up=None) -> int:
        """Shows all of a picture; how many calls that takes."""
        calls = 0
        while calls == 0 or self.canvas.is_busy:
            self.canvas.sync(picture, over, None, close_up)
            calls += 1
        return calls

    def sent(self) -> tuple[int, int]:
        """Messages and bytes of arrays since the last call."""
        sent = self.messages, self.n_bytes
        self.messages = self.n_bytes = 0
        return sent

    def shown(self) -> set[tuple[float, ...]]:
        """What there is to be seen of every dot, shape and edge, as the browser has it."""
        seen: list[np.ndarray] = []
        for kind in self.canvas._chunks._chunks.values():
            for chunk in kind.values():
                if isinstance(chunk, _Dots):
                    dots = chunk._dots
                    seen += [np.c_[dots.points, dots.colors]] if dots.visible else []
                    continue
                nodes, edges = chunk._nodes, chunk.edges
                if nodes.visible:
                    scales, colors = nodes.batched_scales[:, None], nodes.batched_colors
                    seen.append(np.c_[nodes.batched_positions, scales, colors][scales[:, 0] > 0])
                seen += [edges.points.reshape(-1, 6)] if edges.visible else []
        return {tuple(row) for part in seen for row in part.tolist()}


@pytest.fixture
def wire() -> Iterator[Wired]:
    server = make_server("127.0.0.1", 0)
    yield Wired(server)
    server.stop()


@pytest.fixture
def other_wire() -> Iterator[Wired]:
    server = make_server("127.0.0.1", 0)
    yield Wired(server)
    server.stop()


def paths(view: ForestView, option: int):
    path = np.array([[int(view.parents[option]), option]])
    return decision(
        voters=np.array([option]),
        shares=np.array([1.0]),
        paths=path,
        path_distances=np.zeros(path.shape),
        voter_weights=view.weights[[option]],
        slopes=np.zeros((1, 4)),
    )


@pytest.mark.parametrize("n", [2_000, 30_000, 210_000])
def test_what_a_step_sends_does_not_depend_on_the_size_of_the_forest(wire: Wired, n):
    view = big_view(n)
    picture = picture_of(view)
    focus = Focus(lambda: 0.0)
    moments = [Moment(paths(view, option)) for option in (n - 1, n - 2, n - 3)]
    drawn = [overlay(moment, picture, view, SPEC) for moment in moments]
    for over, option in zip(drawn, (n - 1, n - 2, n - 3), strict=True):
        wire.sent()
        wire.show(picture, over, focus.get(picture, (option,), is_moving=True))
    messages, n_bytes = wire.sent()
    assert 0 < messages < 60
    assert n_bytes < 30_000


def test_a_forest_that_grows_sends_what_has_changed(wire: Wired):
    view = big_view(30_010)
    early = first(view, 30_000)
    ground = lay_out(early)
    before = draw(early, ground, SPEC, Look())
    after = draw(view, lay_out(view, ground), SPEC, Look())
    wire.show(before)
    wire.sent()
    wire.show(after)
    _, n_bytes = wire.sent()
    assert 0 < n_bytes < 20 * 2 * CHUNK


def test_one_call_sends_a_bounded_part_of_a_picture(wire: Wired):
    picture = picture_of(big_view(100_000))
    wire.canvas.sync(picture, None, None)
    wire.sent()
    calls = 0
    while wire.canvas.is_busy:
        wire.canvas.sync(picture, None, None)
        _, n_bytes = wire.sent()
        assert n_bytes < AT_A_TIME * CHUNK * 40
        calls += 1
    assert calls == -(-100 // AT_A_TIME) - 1


@pytest.mark.parametrize("seed", range(6))
def test_who_comes_late_sees_what_the_others_see(
    few, monkeypatch, wire: Wired, other_wire: Wired, seed
):
    """However a person went through a past, its looks and its neighbours."""
    monkeypatch.setattr(chunks, "CHUNK", 8)
    monkeypatch.setattr(chunks, "AT_A_TIME", 3)
    rng = np.random.default_rng(seed)
    view, other = random_view(200), random_view(75, seed=1)
    grounds = {id(view): lay_out(view), id(other): lay_out(other)}
    picture = None
    for _ in range(25):
        forest = view if rng.random() < 0.8 else other
        n = len(forest.parents)
        is_alive = np.arange(n) < rng.integers(0, n + 1)
        is_alive &= (rng.random(n) < 0.95) | (forest.parents == NO_OPTION)
        then = replace(forest, is_alive=is_alive)
        order = rng.permutation(n) if rng.random() < 0.3 else None
        look = Look(
            arrangement=Arrangement.CONES if rng.random() < 0.2 else Arrangement.DISCS,
            coloring=Coloring.VALUE if rng.random() < 0.3 else Coloring.ACTION,
        )
        picture = draw(then, grounds[id(forest)], SPEC, look, order=order)
        wire.canvas.sync(picture, None, None)  # The rest of it may never be sent.
    wire.show(picture)
    other_wire.show(picture)
    assert wire.shown() == other_wire.shown()
    assert picture is not None
    n_wanted = int(np.count_nonzero(picture.sizes))
    if detail_for(n_wanted) is Detail.DOTS:
        assert len(wire.shown()) == n_wanted


def test_dots_that_only_change_colour_or_place_are_sent_again(few, wire: Wired):
    view = random_view(80)
    here, there = lay_out(view), lay_out(view, None, 1.7)
    for ground, coloring in (
        (here, Coloring.ACTION),
        (here, Coloring.AGE),
        (there, Coloring.AGE),
    ):
        picture = draw(view, ground, SPEC, Look(coloring=coloring))
        assert picture.detail is Detail.DOTS
        wire.show(picture)
        dots = np.c_[picture.positions[:, :2], picture.colors].tolist()
        assert {(x, y, *color) for x, y, _, *color in wire.shown()} == set(map(tuple, dots))


def test_the_imagined_way_is_drawn_in_all_its_widths(wire: Wired):
    view = random_view(20)
    picture = draw(view, lay_out(view), SPEC, Look())
    ahead = tuple(np.full((n, 2, 3), n, np.float32) for n in (3, 1, 2))
    wire.show(picture, replace(overlay(Moment(None), picture, view, SPEC), ahead=ahead))
    lines = wire.canvas._ahead
    for handle, dashes in zip(lines, ahead, strict=True):
        assert handle.visible
        np.testing.assert_array_equal(handle.points[..., :2], dashes[..., :2])
    assert lines[0].thickness > lines[1].thickness > lines[2].thickness
    wire.show(picture, overlay(Moment(None), picture, view, SPEC))
    assert not any(handle.visible for handle in lines)


def test_a_move_through_the_past_sends_what_came_or_went(wire: Wired):
    """Not what stands beside it, and nothing a second time."""
    n = 40_000
    view, rng = big_view(n), np.random.default_rng(0)
    ground = lay_out(view)
    ends = np.where(rng.random(n) < 0.01, np.arange(n) + rng.integers(1, n, n), 2 * n)
    order = np.argsort(ends <= n, kind="stable")

    def at(step: int) -> Picture:
        then = replace(view, is_alive=(np.arange(n) < step) & (ends > step))
        return draw(then, ground, SPEC, Look(), order=order)

    def sent_by(step: int) -> int:
        wire.sent()
        wire.show(at(step))
        return wire.sent()[1]

    room = CHUNK * 15 + 500  # A chunk of dots, and the discs of roots.
    sent_by(39_900)
    assert 0 < sent_by(30_100) <= 2 * room  # Where the options end, and those that left.
    assert 0 < sent_by(39_500) <= 2 * room
    assert sent_by(10_500) > 5 * room  # As shapes, for the first time.
    assert sent_by(30_200) <= 2 * room
    assert sent_by(10_700) <= 3 * 2 * CHUNK * 28  # Shapes and edges where they end.
    assert wire.show(at(30_200)) <= 2


def test_a_big_forest_is_laid_out_while_the_screen_goes_on():
    gallery, view, key = Gallery(), big_view(20_000), ("run", "1", 0)
    assert gallery.get(key, view, SPEC) is None
    assert gallery.is_busy
    while (picture := gallery.get(key, view, SPEC)) is None:
        pass
    assert not gallery.is_busy
    assert len(picture.sizes) == 20_000
    gallery.close()
