"""Pictures, overlays and colours: what is drawn, tested with numbers alone."""

import time
from dataclasses import replace

import numpy as np
import pytest

from ao2viz.core.decision import NO_OPTION
from ao2viz.figures.coloring import Coloring
from ao2viz.figures.palette import ACTIONS, DARK, LIGHT, UNTRIED
from ao2viz.layout.discs import has_crowded, lay_out
from ao2viz.layout.state_space import fit_axes
from ao2viz.ui.gallery import Gallery
from ao2viz.ui.look import Arrangement, Look
from ao2viz.ui.overlay import SHARE_LEVELS, Moment, overlay
from ao2viz.ui.picture import draw
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


def picture_of(view, **look):
    return draw(view, lay_out(view), SPEC, Look(**look))


def overlay_of(made, selected, view, **look):
    return overlay(Moment(made, selected), picture_of(view, **look), view, SPEC)


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
    drawn = overlay_of(made, NO_OPTION, small_view())
    np.testing.assert_array_equal(drawn.path, picture.positions[made.path])
    np.testing.assert_array_equal(drawn.path_colors, picture.colors[made.path])
    assert [label.text for label in drawn.labels] == ["option 4 → push right", "root 0"]


def test_other_voters_are_drawn_by_their_share():
    drawn = overlay_of(decision(), NO_OPTION, small_view())
    assert len(drawn.voters) == 1
    assert [len(votes) for votes in drawn.votes] == [0, 1, 0]  # A third of the greatest share.
    strong = overlay_of(decision(shares=np.array([0.5, 0.5])), NO_OPTION, small_view())
    assert [len(votes) for votes in strong.votes] == [0, 0, 1]
    assert strong.voter_sizes[0] > drawn.voter_sizes[0]
    silent = overlay_of(decision(shares=np.array([1.0, 0.0])), NO_OPTION, small_view())
    assert len(silent.voters) == 0


def test_labels_look_away_from_each_other():
    chosen, root = overlay_of(decision(), NO_OPTION, small_view()).labels
    # A side is (to the right, downwards): one begins above its option, the other below.
    assert chosen.sides[0].value[1] != root.sides[0].value[1]


def test_options_that_the_forest_lost_are_left_out_of_the_overlay():
    view = small_view()
    gone = replace(view, is_alive=np.array([True, True, True, True, False]))
    drawn = overlay_of(decision(), 4, gone)
    assert len(drawn.path) == 2
    assert drawn.selected is None


def test_without_a_decision_only_the_selection_is_drawn():
    picture = picture_of(small_view())
    drawn = overlay_of(None, 2, small_view())
    assert len(drawn.path) == len(drawn.voters) == 0
    assert [label.text for label in drawn.labels] == ["selected 2"]
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
    assert after.ground is before.ground
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
    gallery.keep_only({(key, Look())})
    view = small_view()
    assert gallery.get(key, view, SPEC).ground is before.ground
    gallery.keep_only(set())
    assert gallery.get(key, view, SPEC).ground is not before.ground


def test_browsers_that_look_alike_share_a_picture_and_others_do_not():
    gallery, key, view = Gallery(Clock()), ("file", "a", 0), small_view()
    plain = gallery.get(key, view, SPEC, Look())
    assert gallery.get(key, view, SPEC, Look()) is plain
    by_value = gallery.get(key, view, SPEC, Look(coloring=Coloring.VALUE))
    assert by_value.ground is plain.ground
    assert by_value.colors.tolist() != plain.colors.tolist()
    assert gallery.get(key, view, SPEC, Look()) is plain


def test_agreement_is_worked_out_beside_and_shown_when_it_is_known():
    gallery, key, view = Gallery(Clock()), ("file", "a", 0), random_view(300)
    look = Look(coloring=Coloring.AGREEMENT)
    try:
        first_look = gallery.get(key, view, SPEC, look)
        assert (first_look.colors == UNTRIED).all()
        deadline = time.monotonic() + 20
        while (gallery.get(key, view, SPEC, look).colors == UNTRIED).all():
            assert time.monotonic() < deadline
    finally:
        gallery.close()


def test_discs_that_grew_into_one_another_glide_apart():
    clock, view = Clock(), random_view(420, roots=12, deepest=3, seed=5)
    gallery, key = Gallery(clock), ("run", "1", 0)
    gallery.get(key, first(view, 14), SPEC)
    for n in range(60, 421, 60):
        picture = gallery.get(key, first(view, n), SPEC)
        clock.now += 10
        picture = gallery.get(key, first(view, n), SPEC)
        assert not has_crowded(picture.ground)


@pytest.mark.parametrize("arrangement", Arrangement)
def test_options_stay_where_they_are_in_every_arrangement(arrangement):
    gallery, view = Gallery(Clock()), random_view(150)
    look = Look(arrangement=arrangement, axes=(1, 3, 0))
    early = gallery.get(("run", "1", 0), first(view, 100), SPEC, look)
    late = gallery.get(("run", "1", 0), view, SPEC, look)
    np.testing.assert_array_equal(late.positions[:100], early.positions)
    assert late.stands.all()


def test_cones_stand_over_their_discs_with_the_root_on_top():
    view = random_view(200)
    flat = picture_of(view)
    cones = picture_of(view, arrangement=Arrangement.CONES)
    np.testing.assert_array_equal(cones.positions[:, :2], flat.positions[:, :2])
    children = np.flatnonzero(view.parents != NO_OPTION)
    assert (cones.positions[children, 2] < cones.positions[view.parents[children], 2]).all()
    assert not cones.is_flat
    assert len(cones.discs[0]) == 0


def test_in_the_state_space_options_stand_at_their_values():
    view = random_view(60)
    axes = fit_axes(view.values, (2, 0))
    picture = draw(view, axes, SPEC, Look(arrangement=Arrangement.STATE_SPACE, axes=(2, 0)))
    order = np.argsort(view.values[:, 2])
    assert (np.diff(picture.positions[order, 0]) > 0).all()
    assert len(picture.edges) == 0  # Only the active schema's are drawn, by the overlay.
    made = decision()
    seen = np.array([np.zeros(4), view.values[7]])
    drawn = overlay(Moment(made, NO_OPTION, seen), picture, view, SPEC)
    np.testing.assert_allclose(drawn.now, picture.positions[7], atol=1e-4)
    schema = picture.schemas[made.path[-1]]
    ends = {tuple(p) for p in picture.positions[picture.schemas == schema].round(4).tolist()}
    assert {tuple(p) for p in drawn.schema.reshape(-1, 3).round(4).tolist()} <= ends
    assert len(drawn.schema) == np.count_nonzero(picture.schemas == schema) - 1
    words = [label.text for label in drawn.labels]
    assert "now" in words[:2]
    assert "pole angle (°)" in words
    assert "cart position (m)" in words


def test_what_is_too_deep_is_hidden_but_never_the_path():
    view = small_view()
    shallow = picture_of(view, deepest=1)
    assert shallow.sizes[4] == 0
    assert shallow.n_hidden == 1
    assert shallow.edge_ends.tolist() == [[0, 1], [0, 2]]
    assert shallow.pick((*shallow.positions[4][:2], 9.0), (0.0, 0.0, -1.0)) != 4
    drawn = overlay_of(decision(), NO_OPTION, view, deepest=1)
    np.testing.assert_array_equal(drawn.path, shallow.positions[decision().path])


def test_a_folded_schema_is_its_root_and_says_what_it_hides():
    view = small_view()
    folded = picture_of(view, folded=frozenset({0}))
    assert (folded.sizes > 0).tolist() == [True, False, False, True, False]
    assert folded.sizes[0] > 1
    assert folded.n_hidden == 3
    assert len(folded.edges) == 0
    labels = overlay_of(None, NO_OPTION, view, folded=frozenset({0, 99, 1})).labels
    assert [label.text for label in labels] == ["root 0 + 3"]


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


SHOWN = [
    color
    for palette in (DARK, LIGHT)
    for color in (*palette.actions, *palette.ramp, *palette.votes, palette.path, palette.untried)
]


@pytest.mark.parametrize("rgb", [*SHOWN, DARK.middle, LIGHT.middle, LIGHT.imagined, LIGHT.disc])
def test_colours_come_out_of_the_film_curve_as_the_legend_shows_them(rgb):
    albedo = to_albedo(np.array(rgb, np.uint8)).astype(float)
    off = np.abs(bend(albedo) - rgb)
    # The curve cannot give a channel that is quite dark beside bright ones.
    assert off[np.argsort(rgb)[1:]].max() < 4
    assert off.max() < 50
