"""HTML, pictures of episodes, the shelf of files: what stands around the canvas."""

import io
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ao2viz.agent import AO2
from ao2viz.envs.catalogue import Feature
from ao2viz.figures.coloring import Coloring
from ao2viz.layout.discs import lay_out
from ao2viz.ui import html
from ao2viz.ui.frames import SIZE, FrameStore, encode, refit
from ao2viz.ui.html_forest import legend
from ao2viz.ui.library import Library
from ao2viz.ui.look import Arrangement, Look
from ao2viz.ui.picture import draw
from ao2viz.ui.world import LoadFailure
from tests.forests import cartpole, decision, small_view

EVIL = "<img src=x onerror=alert(1)>\"'&"
QUICK = {"warmup_steps": 20, "levels": 1}


@pytest.fixture(scope="module")
def agent() -> AO2:
    trained = AO2("CartPole-v1", seed=0, **QUICK).learn(60)
    trained.record_episode(5)
    return trained


def hostile_spec():
    spec = cartpole()
    features = tuple(Feature(EVIL, EVIL) for _ in spec.features)
    return replace(spec, title=EVIL, env_id=EVIL, features=features, action_names=(EVIL, EVIL))


def test_nothing_from_a_file_becomes_html():
    spec, view, made = hostile_spec(), small_view(), decision(is_tie=True, created=3)
    pages = [
        html.decision(made, spec, view),
        html.path(made, spec, view),
        html.option(4, view, spec, made.observation),
        legend(spec, view, Look(), picture_of(spec, view)),
        html.notice(EVIL),
    ]
    for page in pages:
        assert "<img" not in page
        assert "&lt;img" in page
        assert EVIL not in page


def test_the_stack_shows_the_recorded_path_and_the_action_at_its_end():
    page = html.path(decision(), cartpole(), small_view())
    order = [page.index(words) for words in ("root <b>0", "option <b>1", "option <b>4")]
    assert order == sorted(order)
    assert order[-1] < page.index("<b>push right")
    assert "Second most similar: option 1" in page


def test_a_long_path_loses_its_middle_and_says_so():
    n = 40
    made = decision(
        voters=np.array([4]),
        shares=np.array([1.0]),
        paths=np.array([[0] * n]),
        path_distances=np.ones((1, n)),
    )
    page = html.path(made, cartpole(), small_view())
    assert "28 options between" in page
    assert page.count("<li") == 12 + 1 + 1


def test_an_option_is_shown_beside_what_is_seen():
    page = html.option(4, small_view(), cartpole(), decision().observation)
    for words in ("Option 4", "made at step 7", "3.44°", "4.58°", "92.2", "12 visits", "depth 2"):
        assert words in page


def test_an_option_that_tried_nothing_prefers_nothing():
    page = html.option(3, small_view(), cartpole(), None)
    assert page.count("never tried") == 2
    assert "<b>push" not in page
    assert "tried nothing" in html.related(3, small_view(), cartpole())


def test_weights_that_differ_look_different():
    view = small_view()
    weights = view.weights.copy()
    weights[4] = 194.584, 194.580
    page = html.option(4, replace(view, weights=weights), cartpole(), None)
    assert "194.584" in page
    assert "194.580" in page


def picture_of(spec, view, **look):
    return draw(view, lay_out(view), spec, Look(**look))


def test_the_legend_counts_options_and_schemas():
    view, spec = small_view(), cartpole()
    page = legend(spec, view, Look(), picture_of(spec, view))
    assert "5 options in 2 schemas" in page
    assert "prefers push left" in page
    assert "path to the most similar option" in page
    assert "hidden" not in page
    assert "Start grows one" in legend(None, None, Look(), None)
    assert "on its way" in legend(None, None, Look(), None, is_coming=True)


@pytest.mark.parametrize(
    ("coloring", "words"),
    [
        (Coloring.VALUE, ("expected return", "2.00", "92.2")),
        (Coloring.VISITS, ("how often it was visited", "1 visit", "15 visits")),
        (Coloring.AGE, ("when it was made", "step 7")),
        (Coloring.AGREEMENT, ("8 nearest prefer the same", "none", "half", "all")),
    ],
)
def test_the_legend_explains_the_colours_that_are_shown(coloring, words):
    view, spec = small_view(), cartpole()
    look = Look(coloring=coloring)
    page = legend(spec, view, look, picture_of(spec, view, coloring=coloring))
    for word in words:
        assert word in page
    assert "prefers push" not in page


def test_the_legend_says_how_many_options_are_hidden():
    view, spec = small_view(), cartpole()
    look = {"deepest": 0, "arrangement": Arrangement.CONES}
    page = legend(spec, view, Look(**look), picture_of(spec, view, **look))
    assert "3 options hidden" in page
    assert "cones" in page


def size_of(jpeg: bytes) -> tuple[int, int]:
    with Image.open(io.BytesIO(jpeg)) as image:
        return image.size


def corner(jpeg: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(jpeg)) as image:
        return np.asarray(image)[5, 5]


@pytest.mark.parametrize("shape", [(400, 600, 3), (500, 500, 3), (40, 900, 3), (3, 2, 3)])
def test_pictures_of_any_shape_come_out_equally_big(shape):
    assert size_of(encode(np.full(shape, 255, np.uint8))) == SIZE


def test_white_pages_turn_dark_and_pictures_stay_as_they_are():
    page = np.full((400, 600, 3), 255, np.uint8)
    assert corner(encode(page)).max() < 60
    photo = np.full((280, 420, 3), (40, 120, 200), np.uint8)
    np.testing.assert_allclose(corner(encode(photo)), (40, 120, 200), atol=6)
    buffer = io.BytesIO()
    Image.fromarray(page).save(buffer, "JPEG")
    assert corner(refit(buffer.getvalue())).max() < 60


def wait_for_frame(store: FrameStore, episode, spec, position: int) -> tuple[bytes | None, str]:
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        frame, problem = store.get(episode, spec, position)
        if frame is not None or problem:
            return frame, problem
        time.sleep(0.02)
    raise AssertionError("No picture came.")


def test_every_step_of_a_recorded_episode_has_its_picture(agent):
    store, episode = FrameStore(), agent.episodes[-1]
    try:
        last, problem = wait_for_frame(store, episode, agent.spec, len(episode))
        assert problem == ""
        firsts, _ = wait_for_frame(store, episode, agent.spec, 0)
        assert firsts != last
    finally:
        store.close()


def test_an_episode_that_cannot_be_repeated_says_why_it_has_no_picture(agent):
    store, episode = FrameStore(), agent.episodes[-1]
    other = replace(episode, observations=episode.observations + 0.5)
    unknown = replace(episode, env_id="Nowhere-v9")
    try:
        assert "no longer repeats" in wait_for_frame(store, other, agent.spec, 0)[1]
        assert "Nowhere-v9" in wait_for_frame(store, unknown, agent.spec, 0)[1]
    finally:
        store.close()


def opened(library: Library, path: Path):
    library.open(path)
    deadline = time.monotonic() + 30
    while path not in library.opened and time.monotonic() < deadline:
        library.poll()
        time.sleep(0.02)
    return library.opened[path]


def test_the_shelf_lists_given_shipped_and_saved_files_once(tmp_path, agent):
    shipped, saved = tmp_path / "shipped", tmp_path / "saved"
    given = agent.save(tmp_path / "mine.ao2")
    for path in (shipped / "CartPole-v1.ao2", saved / "CartPole-v1.ao2", saved / "b.ao2"):
        agent.save(path)
    (saved / "note.txt").write_text("no agent")
    (saved / ".half.ao2").write_text("hidden")
    library = Library(shipped, saved, Path(given) if given else tmp_path / "mine.ao2")
    try:
        labels = [item.label for item in library.shelf()]
        assert labels == ["mine", "CartPole-v1", "CartPole-v1 (saved)", "b"]
    finally:
        library.close()


def test_files_are_opened_and_broken_ones_are_told(tmp_path, agent):
    agent.save(tmp_path / "good.ao2")
    (tmp_path / "bad.ao2").write_bytes(b"this is no agent")
    library = Library(tmp_path, tmp_path)
    try:
        good = opened(library, tmp_path / "good.ao2")
        assert len(good.forest_view()) == len(agent.forest)
        for name in ("bad.ao2", "missing.ao2"):
            bad = opened(library, tmp_path / name)
            assert isinstance(bad, LoadFailure)
            assert name in bad.message
    finally:
        library.close()


def test_a_file_that_was_written_again_is_read_again(tmp_path, agent):
    path = tmp_path / "again.ao2"
    agent.save(path)
    library = Library(tmp_path, tmp_path)
    try:
        before = opened(library, path)
        assert not library.forget_changed()
        agent.save(path)
        assert library.forget_changed()
        after = opened(library, path)
        assert after is not before
        path.unlink()
        assert not library.forget_changed()  # What somebody watches stays.
        assert library.opened[path] is after
    finally:
        library.close()
