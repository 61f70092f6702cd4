"""The labels of one browser's canvas, put where its camera leaves room for them."""

from typing import Literal

import numpy as np
import viser

from ao2viz.layout.labels import Side, Words, place_labels
from ao2viz.ui.camera import Lens
from ao2viz.ui.overlay import Label, Overlay

_MOST = 24
_EM_PX = 12.0  # What viser makes of a scale of 1.
_LETTER = 0.56  # Width of a letter in ems, rather too much than too little.
_LINE = 1.5  # Height of a label in ems.

_Anchor = Literal[
    "bottom-left", "bottom-right", "top-left", "top-right", "center-left", "center-right"
]
# The corner of the label that sticks to its point.
_ANCHORS: dict[Side, _Anchor] = {
    Side.RIGHT_ABOVE: "bottom-left",
    Side.LEFT_ABOVE: "bottom-right",
    Side.RIGHT_BELOW: "top-left",
    Side.LEFT_BELOW: "top-right",
    Side.RIGHT: "center-left",
    Side.LEFT: "center-right",
}


class Lettering:
    """A handful of viser's labels, reused. Only the app loop may call it."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._handles = [
            scene.add_label(f"/labels/{i}", "", visible=False, font_screen_scale=1.0)
            for i in range(_MOST)
        ]
        self._placed: tuple[Overlay | None, bytes] = (None, b"")

    def sync(self, overlay: Overlay | None, lens: Lens | None) -> None:
        """Shows the labels of an overlay, those that would overlap left out."""
        eye = b"" if lens is None else np.r_[lens.position, *lens.rotation, lens.window].tobytes()
        if self._placed[0] is overlay and self._placed[1] == eye:
            return
        self._placed = (overlay, eye)
        labels = overlay.labels[:_MOST] if overlay is not None and lens is not None else ()
        sides = choose_sides(labels, overlay, lens) if overlay and lens else []
        for i, handle in enumerate(self._handles):
            side = sides[i] if i < len(sides) else None
            handle.visible = side is not None
            if side is None:
                continue
            text = labels[i].text
            # A gap between the words and their point.
            handle.text = f"{text}  " if side.name.startswith("LEFT") else f"  {text}"
            handle.anchor = _ANCHORS[side]
            handle.position = labels[i].position


def choose_sides(labels: tuple[Label, ...], overlay: Overlay, lens: Lens) -> list[Side | None]:
    """Where each label stands beside its point; None: there is no room for it."""
    if not labels:
        return []
    points, depths = lens.see(np.array([label.position for label in labels]))
    words = [
        Words(
            # Behind the camera is outside of the window.
            (float(x), float(y)) if depth > 0 else (-1e9, -1e9),
            ((len(label.text) + 2) * _LETTER * _EM_PX, _LINE * _EM_PX),
            label.sides,
        )
        for label, (x, y), depth in zip(labels, points, depths, strict=True)
    ]
    keep_free, _ = lens.see(overlay.path.reshape(-1, 3))
    return place_labels(words, lens.window, keep_free)
