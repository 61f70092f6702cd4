"""Pictures, overlays and colours: what is drawn, tested with numbers alone."""

from dataclasses import replace

import numpy as np
import pytest

from ao2viz.core.decision import NO_OPTION
from ao2viz.figures.palette import ACTIONS, PATH, UNTRIED
from ao2viz.layout.discs import lay_out
from ao2viz.ui.overlay import SHARE_LEVELS, overlay
from ao2viz.ui.picture import Gallery, draw
from ao2viz.ui.tones import to_albedo
from tests.forests import cartpole, decision, first, random_view, small_view, with_parents

SPEC = cartpole()


class Clock:
    """Time that passes when told to, and a little at each look."""

    def __init__(self, cost_s: float = 0.0) -> None:
        self.now, self._cost_s = 100.0, cost_s

    def __call__(self) -> float:
        self.now += self._cost_s
        return self.now


def picture_of(view):
    return draw(view, lay_out(view), SPEC)


def test_options_are_coloured_by_what_they_prefer_and_sized_by_visits():
    picture = picture_of(small_view())
    assert picture.colors.tolist() == [
        list(ACTIONS[1]),
        list(ACTIONS[1]),
        list(ACTIONS[0]),
        list(UNTRIED),
        list(ACTIONS[1]),
    ]
    assert picture.sizes[4] > picture.sizes[1] > picture.sizes[0] > picture.sizes[3] > 0
    assert picture.sizes.max() < 0.5  # Half the smallest distance: discs never touch.


def test_edges_lead_from_parents_to_children():
    picture = picture_of(small_view())
    assert picture.edge_ends.tolist() == [[0, 1], [0, 2], [1, 4]]
    np.testing.assert_array_equal(picture.edges[:, 1], picture.positions[[1, 2, 4]])


def test_cleansed_options_are_not_drawn_and_not_picked():
    view = small_view()
    gone = replace(view, is_alive=np.array([True, True, True, False, True]))
    picture = picture_of(gone)
    assert picture.sizes[3] == 0
    assert picture.position_of(3) is None
    assert picture.pick((0.0, 0.0, 9.0), (0.0, 0.0, -1.0)) != 3


def test_a_ray_picks_the_option_it_meets_however_the_camera_stands():
    picture = picture_of(random_view(300))
    rng = np.random.default_rng(0)
    for option in rng.choice(300, 40, replace=False):
        camera = np.array([*rng.normal(scale=30, size=2), rng.uniform(20, 200)])
        toward = picture.positions[option] - camera
        assert picture.pick(tuple(camera), tuple(toward / np.linalg.norm(toward))) == option


@pytest.mark.parametrize(
    ("origin", "direction"),
    [
        ((0.0, 0.0, 50.0), (0.0, 0.0, 1.0)),
        ((0.0, 0.0, 50.0), (0.0, 1.0, 0.0)),
        ((900.0, 0.0, 50.0), (0.0, 0.0, -1.0)),
        ((np.nan, 0.0, 50.0), (0.0, 0.0, -1.0)),
        ((0.0,), (0.0, 0.0, -1.0)),
    ],
)
def test_rays_that_meet_nothing_pick_nothing(origin, direction):
    assert picture_of(small_view()).pick(origin, direction) == NO_OPTION


def test_the_path_that_is_drawn_is_the_path_that_was_recorded():
    picture, made = picture_of(small_view()), decision()
    drawn = overlay(made, NO_OPTION, picture, SPEC)
    np.testing.assert_array_equal(drawn.path, picture.positions[made.path])
    np.testing.assert_array_equal(drawn.path_colors, picture.colors[made.path])
    assert [label.text for label in drawn.labels] == ["option 4 → push right", "root 0"]


def test_other_voters_are_drawn_by_their_share():
    picture = picture_of(small_view())
    drawn = overlay(decision(), NO_OPTION, picture, SPEC)
    assert len(drawn.voters) == 1
    assert [len(votes) for votes in drawn.votes] == [0, 1, 0]  # A third of the greatest share.
    strong = overlay(decision(shares=np.array([0.5, 0.5])), NO_OPTION, picture, SPEC)
    assert [len(votes) for votes in strong.votes] == [0, 0, 1]
    assert strong.voter_sizes[0] > drawn.voter_sizes[0]
    silent = overlay(decision(shares=np.array([1.0, 0.0])), NO_OPTION, picture, SPEC)
    assert len(silent.voters) == 0


def test_labels_look_away_from_each_other():
    picture = picture_of(small_view())
    chosen, root = overlay(decision(), NO_OPTION, picture, SPEC).labels
    assert chosen.is_above != root.is_above


def test_options_that_the_forest_lost_are_left_out_of_the_overlay():
    view = small_view()
    gone = picture_of(replace(view, is_alive=np.array([True, True, True, True, False])))
    drawn = overlay(decision(), 4, gone, SPEC)
    assert len(drawn.path) == 2
    assert drawn.selected is None


def test_without_a_decision_only_the_selection_is_drawn():
    picture = picture_of(small_view())
    drawn = overlay(None, 2, picture, SPEC)
    assert len(drawn.path) == len(drawn.voters) == len(drawn.labels) == 0
    assert len(drawn.votes) == SHARE_LEVELS
    np.testing.assert_array_equal(drawn.selected, picture.positions[2])


def test_a_growing_run_keeps_its_options_in_place():
    gallery, view = Gallery(Clock()), random_view(90)
    before = gallery.get(("run", "1", 0), first(view, 40), SPEC)
    after = gallery.get(("run", "1", 0), view, SPEC)
    np.testing.assert_array_equal(after.positions[:40], before.positions)
    assert len(after.sizes) == 90


def test_new_weights_recolour_without_a_new_layout():
    gallery, view = Gallery(Clock()), small_view()
    before = gallery.get(("run", "1", 0), view, SPEC)
    after = gallery.get(("run", "1", 0), replace(view, weights=-view.weights), SPEC)
    assert after.layout is before.layout
    assert after.colors.tolist() != before.colors.tolist()


def test_a_regrown_forest_glides_to_a_fresh_arrangement():
    clock, view = Clock(), random_view(120)
    gallery, key = Gallery(clock), ("run", "1", 0)
    before = gallery.get(key, view, SPEC)
    parents = view.parents.copy()
    parents[40:] = 0
    regrown = with_parents(view, parents, view.is_alive)
    start = gallery.get(key, regrown, SPEC)
    np.testing.assert_allclose(start.positions, before.positions, atol=1e-5)
    clock.now += 0.45
    middle = gallery.get(key, regrown, SPEC).positions
    clock.now += 10
    end = gallery.get(key, regrown, SPEC).positions
    np.testing.assert_allclose(middle, (before.positions + end) / 2, atol=0.02)
    np.testing.assert_allclose(end[:, :2], lay_out(regrown, None, 1.7).positions.astype(np.float32))


def test_a_forest_that_takes_long_to_lay_out_is_drawn_less_often():
    clock = Clock(cost_s=0.2)
    gallery, view, key = Gallery(clock), random_view(60), ("run", "1", 0)
    before = gallery.get(key, first(view, 30), SPEC)
    assert gallery.get(key, first(view, 40), SPEC) is before
    clock.now += 5
    assert len(gallery.get(key, view, SPEC).sizes) == 60


def test_pictures_nobody_watches_are_forgotten():
    gallery, key = Gallery(Clock()), ("file", "a", 0)
    before = gallery.get(key, small_view(), SPEC)
    gallery.keep_only({key})
    view = small_view()
    assert gallery.get(key, view, SPEC).layout is before.layout
    gallery.keep_only(set())
    assert gallery.get(key, view, SPEC).layout is not before.layout


def bend(albedo: np.ndarray) -> np.ndarray:
    """What three.js makes of a lit colour: the film curve, forwards."""
    into = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
    out = [
        [1.60475, -0.53108, -0.07367],
        [-0.10208, 1.10813, -0.00605],
        [-0.00327, -0.07276, 1.07602],
    ]
    v = np.array(into) @ (albedo / 255 * 4.6 / np.pi / 0.6)
    v = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081)
    linear = np.clip(np.array(out) @ v, 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("rgb", [*ACTIONS, PATH, UNTRIED, (216, 219, 224)])
def test_colours_come_out_of_the_film_curve_as_the_legend_shows_them(rgb):
    albedo = to_albedo(np.array(rgb, np.uint8)).astype(float)
    off = np.abs(bend(albedo) - rgb)
    # The curve cannot give a channel that is quite dark beside bright ones.
    assert off[np.argsort(rgb)[1:]].max() < 4
    assert off.max() < 50
