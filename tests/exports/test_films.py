"""Films of an episode, opened by other people's players."""

from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image, ImageSequence

from ao2viz.figures import fonts, raster
from ao2viz.store.saved import SavedAgent
from tests.exports.agents import first_steps
from tests.exports.conftest import Export

STEPS = 6


@pytest.fixture
def short(cartpole: SavedAgent) -> SavedAgent:
    return replace(cartpole, episodes=tuple(first_steps(e, STEPS) for e in cartpole.episodes))


def shows_a_path(frame: np.ndarray) -> bool:
    """Something on the right is pink, whatever the compression made of thin lines."""
    r, g, b = np.moveaxis(frame[:, 500:].astype(int), 2, 0)
    return bool(((r - g > 50) & (b - g > 20) & (r > b)).sum() > 50)


def shows_the_cart(frame: np.ndarray) -> bool:
    """Something on the left is brown, as the pole is."""
    r, g, b = np.moveaxis(frame[:, :500].astype(int), 2, 0)
    return bool(((r - b > 50) & (r > g) & (g > b)).sum() > 50)


def test_mp4_has_a_picture_of_every_step(short: SavedAgent, write: Export) -> None:
    shares: list[float] = []
    with av.open(str(write(short, "mp4", progress=shares.append))) as film:
        track = film.streams.video[0]
        assert track.codec_context.name == "h264"
        assert track.average_rate == 10
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(frames) == STEPS
    assert shares == [step / STEPS for step in range(STEPS + 1)]
    assert frames[0].shape == (640, 1200, 3)
    assert all(shows_a_path(frame) and shows_the_cart(frame) for frame in frames)
    assert np.abs(frames[0].astype(int) - frames[-1]).max() > 100


def test_gif_has_a_picture_of_every_step_and_repeats(short: SavedAgent, write: Export) -> None:
    with Image.open(write(short, "gif", episode=0)) as film:
        assert film.info["loop"] == 0
        assert film.info["duration"] == 100
        frames = [np.asarray(f.convert("RGB")) for f in ImageSequence.Iterator(film)]
    assert len(frames) == STEPS
    assert all(shows_a_path(frame) and shows_the_cart(frame) for frame in frames)


@pytest.mark.parametrize("format", ["mp4", "gif"])
def test_what_cannot_be_drawn_leaves_no_film(
    short: SavedAgent, write: Export, tmp_path: Path, format: str
) -> None:
    changed = replace(short.episodes[0], seed=12345)
    with pytest.raises(ValueError, match="no longer repeats this recording: step 0"):
        write(replace(short, episodes=(changed,)), format)

    def stop(share: float) -> None:
        if share > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        write(short, format, progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_hostile_names_can_be_filmed(tiny: SavedAgent, write: Export) -> None:
    short = replace(tiny, episodes=(first_steps(tiny.episodes[0], 2),))
    with Image.open(write(short, "gif")) as film:
        assert film.n_frames == 2


def test_names_in_other_scripts_are_no_boxes_in_pictures_and_films(
    short: SavedAgent, write: Export, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[str] = []
    to_runs = raster.to_runs

    def note(text: str, *, is_bold: bool = False) -> tuple[fonts.Run, ...]:
        runs = to_runs(text, is_bold=is_bold)
        drawn.extend(run.text for run in runs if run.font is None)
        return runs

    monkeypatch.setattr(raster, "to_runs", note)
    names = ("推左 push", "推右 push")
    named = replace(short, spec=replace(short.spec, title="小車", action_names=names))
    for format in ("png", "path-png", "gif", "mp4"):
        write(named, format, **({"step": 0} if format.endswith("png") else {}))
    assert any("push" in text for text in drawn)
    own = fonts.own_font(False)
    assert all(fonts._has(own, letter) for text in drawn for letter in text)
