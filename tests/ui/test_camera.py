"""The camera: what it is asked to show is in the window, and it lets people look elsewhere."""

from types import SimpleNamespace

import numpy as np
import pytest

from ao2viz.layout.discs import lay_out
from ao2viz.ui.camera import Eye, Lens, find_view
from ao2viz.ui.look import Arrangement, Look
from ao2viz.ui.picture import draw
from tests.forests import cartpole, random_view

WINDOW, PANEL = (792.0, 810.0), (240.0, 260.0)


def lens_at(target, back, distance) -> Lens:
    """What a camera sees that looks at a target from a direction."""
    up = np.array([0.0, 1.0, 0.0]) if abs(back[2]) > 0.999 else np.array([0.0, 0.0, 1.0])
    forward = -back
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    rotation = np.column_stack([right, down, forward])
    return Lens(target + distance * back, rotation, 0.6, WINDOW)


@pytest.mark.parametrize("arrangement", [Arrangement.DISCS, Arrangement.CONES])
@pytest.mark.parametrize("n", [5, 300, 4_000])
def test_every_option_is_in_the_window_and_beside_the_panel(arrangement, n):
    view = random_view(n, roots=max(2, n // 60), deepest=5)
    picture = draw(view, lay_out(view), cartpole(), Look(arrangement=arrangement))
    lens = lens_at(*find_view(picture.outline, picture.is_flat, WINDOW, PANEL))
    seen, depth = lens.see(picture.positions)
    assert (depth > 0).all()
    assert (seen > 0).all()
    assert (seen < WINDOW).all()
    assert not ((seen[:, 0] < PANEL[0]) & (WINDOW[1] - seen[:, 1] < PANEL[1])).any()
    # And not from far away: it fills half of the window at least, in one direction.
    assert ((seen.max(axis=0) - seen.min(axis=0)) / WINDOW).max() > 0.5


def camera(width: int, height: int, **changes):
    plain = {
        "image_width": width,
        "image_height": height,
        "fov": 0.6,
        "position": np.array([0.0, 0.0, 50.0]),
        "wxyz": np.array([0.0, 1.0, 0.0, 0.0]),  # Looks down.
    }
    return SimpleNamespace(**{**plain, **changes})


def test_a_point_in_front_is_seen_in_the_middle_and_right_is_right():
    lens = Eye(camera(800, 600)).look()
    assert lens is not None
    seen, depth = lens.see(np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0]]))
    np.testing.assert_allclose(seen[0], (400, 300))
    assert seen[1, 0] > 400
    assert seen[2, 1] < 300  # Up.
    np.testing.assert_allclose(depth, 50)


def test_a_browser_that_draws_coarsely_keeps_its_window():
    made = camera(792, 810)
    eye = Eye(made)
    assert eye.look().window == (792, 810)
    made.image_width, made.image_height = 594, 608  # Slow: it draws fewer pixels.
    assert eye.look().window == (792, 810)
    made.image_width, made.image_height = 600, 300  # Another shape.
    assert eye.look().window == (600, 300)


@pytest.mark.parametrize(
    "broken",
    [{"image_height": 0}, {"fov": np.nan}, {"position": np.array([np.inf, 0, 0])}, {"fov": 0.0}],
)
def test_a_camera_that_makes_no_sense_is_ignored(broken):
    assert Eye(camera(800, 600, **broken)).look() is None
