"""An episode as a film: the environment, and beside it the path and the sentence of each step."""

import io
from collections.abc import Iterator
from fractions import Fraction
from typing import IO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ao2viz.explain.agreement import tell_faithfulness
from ao2viz.explain.words import number
from ao2viz.exports.content import Content
from ao2viz.figures.drawing import LIGHT, Drawing, Text
from ao2viz.figures.pictures import draw_path
from ao2viz.figures.raster import shorten, to_image
from ao2viz.training.replay import replay_pictures

_RATE = 10  # Steps a second: a path can be followed with the eyes.
_SIZE = (1200, 640)  # Even, as video wants it.
_PICTURE = (500, 500)  # Of the environment, at most.
_TOP, _MARGIN = 56, 24
_GIF_SCALE = 0.7


def write_mp4(content: Content, stream: IO[bytes]) -> None:
    """A film in H.264, ten steps a second.

    Raises:
        ValueError: If there is no episode, or the environment cannot draw it.
    """
    import av  # noqa: PLC0415 -- an extra.

    # In memory first: errors of the disk would reach us as the library's own, without a reason.
    written = io.BytesIO()
    with av.open(written, "w", format="mp4") as film:
        track = film.add_stream("libx264", rate=Fraction(_RATE), options={"crf": "20"})
        track.width, track.height = _SIZE
        track.pix_fmt = "yuv420p"
        for image in _frames(content):
            film.mux(track.encode(av.VideoFrame.from_image(image)))
        film.mux(track.encode())
    stream.write(written.getbuffer())


def write_gif(content: Content, stream: IO[bytes]) -> None:
    """A film that plays wherever a picture can stand, ten steps a second, for ever.

    Raises:
        ValueError: If there is no episode, or the environment cannot draw it.
    """
    small = round(_SIZE[0] * _GIF_SCALE), round(_SIZE[1] * _GIF_SCALE)
    frames = (
        image.resize(small, Image.Resampling.LANCZOS).quantize(64, Image.Quantize.FASTOCTREE)
        for image in _frames(content)
    )
    first = next(frames)
    first.save(stream, "GIF", save_all=True, append_images=frames, duration=1000 // _RATE, loop=0)


def _frames(content: Content) -> Iterator[Image.Image]:
    """A picture of every step."""
    numbered = content.chosen
    episode = numbered.episode
    pictures = replay_pictures(episode, content.spec, content.env_id)
    earned, width = np.cumsum(episode.rewards), _SIZE[0] - _PICTURE[0] - 60.0
    note = tell_faithfulness(content.faithfulness)
    for step, pixels in zip(content.steps(numbered), pictures, strict=False):
        t = step.number
        head = (
            f"{content.spec.title} · episode {numbered.number} · step {t} of {len(episode) - 1} · "
            f"return so far {number(float(earned[t]), 4)}"
        )
        path = draw_path(step.decision, content.spec, content.view, width, note=note)
        yield _compose(head, pixels, path)
        content.progress((t + 1) / len(episode))


def _compose(head: str, pixels: NDArray[np.uint8], path: Drawing) -> Image.Image:
    width, height = _SIZE
    text = Text(_MARGIN, 36, shorten(head, 18, width - 2 * _MARGIN), 18, LIGHT.ink, is_bold=True)
    board = Image.new("RGB", _SIZE, LIGHT.paper)
    board.paste(to_image(Drawing(width, _TOP, (text,), head, LIGHT.paper)))
    picture = Image.fromarray(pixels.astype(np.uint8))
    picture.thumbnail(_PICTURE, Image.Resampling.LANCZOS)
    board.paste(picture, (_MARGIN, _TOP))
    # A path that is taller than the film is drawn smaller, so that its end is never cut off.
    stack = to_image(path, min(1.0, (height - _TOP) / path.height))
    board.paste(stack, (_PICTURE[0] + _MARGIN + 12, _TOP - 12))
    return board
