"""Pictures of recorded episodes, drawn again from seed and actions while people watch."""

import io
from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ao2viz.envs.task import TaskSpec
from ao2viz.figures.palette import Theme
from ao2viz.recording.episode import Episode
from ao2viz.training.replay import replay_pictures

SIZE = (420, 280)
"""Pixels; the picture is shown about 280 wide, on screens with up to two pixels to a point."""

_QUALITY = 82
_KEPT_EPISODES = 6
_PANEL = np.array([26, 29, 36])  # The background of the dock that holds the picture.
_BOARDS = {Theme.DARK: (26, 29, 36), Theme.LIGHT: (255, 255, 255)}
# [3, 256] black becomes the panel's colour, white stays.
_ONTO_PANEL = np.linspace(_PANEL, 255, 256).round().astype(np.uint8).T


@dataclass
class _Reel:
    """The pictures of one episode; the thread appends, the app loop reads."""

    episode: Episode  # Held so that its id stays its own.
    theme: Theme
    frames: list[bytes] = field(default_factory=list)
    problem: str = ""
    is_wanted: bool = True
    is_done: bool = False


class FrameStore:
    """Draws episodes in a thread of its own and keeps the pictures of the latest few."""

    def __init__(self) -> None:
        self._reels: OrderedDict[tuple[int, Theme], _Reel] = OrderedDict()
        self._thread = ThreadPoolExecutor(1, "pictures")

    @property
    def is_busy(self) -> bool:
        """Whether pictures are on their way."""
        return any(not reel.is_done for reel in self._reels.values())

    def get(
        self, episode: Episode, spec: TaskSpec, position: int, theme: Theme = Theme.DARK
    ) -> tuple[bytes | None, str]:
        """The JPEG at this step, or None with a reason (empty while it is being drawn)."""
        reel = self._reels.get((id(episode), theme))
        if reel is None:
            reel = self._reels[id(episode), theme] = _Reel(episode, theme)
            self._thread.submit(_draw_reel, reel, spec)
            while len(self._reels) > _KEPT_EPISODES:
                self._reels.popitem(last=False)[1].is_wanted = False
        self._reels.move_to_end((id(episode), theme))
        if position < len(reel.frames):
            return reel.frames[position], ""
        return None, reel.problem

    def close(self) -> None:
        """Stops drawing."""
        for reel in self._reels.values():
            reel.is_wanted = False
        self._thread.shutdown(wait=True, cancel_futures=True)


def refit(jpeg: bytes, theme: Theme = Theme.DARK) -> bytes:
    """A picture that arrives as JPEG, fitted to the dock like all others."""
    with Image.open(io.BytesIO(jpeg)) as image:
        return encode(np.asarray(image.convert("RGB")), theme)


def encode(pixels: NDArray[np.uint8], theme: Theme = Theme.DARK) -> bytes:
    """A picture [height, width, 3] as a JPEG of SIZE that suits the dock.

    All come out equally big, so that nothing below them moves when another one is shown.
    """
    image = Image.fromarray(pixels)
    scale = min(SIZE[0] / image.width, SIZE[1] / image.height)
    fitted = round(image.width * scale), round(image.height * scale)
    image = image.resize(fitted, Image.Resampling.BILINEAR)
    shown = np.asarray(image)
    if theme is Theme.DARK and _is_page(shown):
        image = Image.fromarray(_turn_dark(shown))
    board = Image.new("RGB", SIZE, _BOARDS[theme])
    board.paste(image, ((SIZE[0] - fitted[0]) // 2, (SIZE[1] - fitted[1]) // 2))
    return _to_jpeg(board)


def _to_jpeg(image: Image.Image) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=_QUALITY)
    return buffer.getvalue()


def _is_page(pixels: NDArray[np.uint8]) -> bool:
    """Whether most of the rim is white, as in all classic control tasks."""
    rim = np.concatenate([pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]])
    return bool((rim.min(axis=1) >= 250).mean() > 0.6)


def _turn_dark(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Swaps light and dark but keeps hues: the page becomes the dock's colour."""
    low = np.minimum(np.minimum(pixels[..., 0], pixels[..., 1]), pixels[..., 2])
    high = np.maximum(np.maximum(pixels[..., 0], pixels[..., 1]), pixels[..., 2])
    shift = 255 - high.astype(np.int16) - low
    flipped = (pixels + shift[..., None]).astype(np.uint8)
    return _ONTO_PANEL[np.arange(3), flipped]


def _draw_reel(reel: _Reel, spec: TaskSpec) -> None:
    try:
        for pixels in replay_pictures(reel.episode, spec):
            if not reel.is_wanted:
                return
            reel.frames.append(encode(pixels, reel.theme))
    except Exception as error:  # Whatever a stranger's environment raises is shown in words.
        reel.problem = f"No picture: {error}"
    reel.is_done = True


BLANK = np.full((SIZE[1], SIZE[0], 3), _PANEL.astype(np.uint8), np.uint8)
"""Stands where a picture will be; as big as most, so that nothing jumps."""


def _blank(theme: Theme) -> bytes:
    """What stands there until a picture is drawn, and where none can be."""
    board = Image.new("RGB", SIZE, _BOARDS[theme])
    middle = (SIZE[0] / 2, SIZE[1] / 2)
    ImageDraw.Draw(board).text(
        middle, "no picture yet", theme.palette.dim, anchor="mm", font_size=20
    )
    return _to_jpeg(board)


BLANK_JPEGS = {theme: _blank(theme) for theme in Theme}
