"""What the canvas shows at a stage of a step: less than a decision at first, then what changed."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.growth import GrowthKind
from ao2viz.explain.cycle import TOLD_CHANGES, change_of
from ao2viz.explain.words import number
from ao2viz.layout.labels import Side
from ao2viz.recording.cycle import Cycle, Stage
from ao2viz.ui.overlay import Label, Overlay
from ao2viz.ui.picture import Picture
from ao2viz.ui.walking import Walk

_MARK_SIZE = 0.75
_MARKED = 64  # At most so many options are marked.
_SIDES = (Side.RIGHT_BELOW, Side.LEFT_BELOW, Side.RIGHT_ABOVE, Side.LEFT_ABOVE)


def at_stage(drawn: Overlay, walk: Walk, picture: Picture) -> Overlay:
    """The overlay of the step's decision, as far as the stage has come."""
    cycle, stage = walk.cycle, walk.stage
    if stage is Stage.SAMPLE:
        nothing = drawn.path[:0]
        return replace(
            drawn,
            path=nothing,
            path_sizes=drawn.path_sizes[:0],
            path_colors=drawn.path_colors[:0],
            votes=tuple(level[:0] for level in drawn.votes),
            voters=nothing,
            voter_sizes=drawn.voter_sizes[:0],
            schema=drawn.schema[:0],
            labels=tuple(label for label in drawn.labels if not _is_of_path(label, cycle)),
        )
    if stage is Stage.FIND:
        found = f"option {_decided(cycle)}, distance {number(cycle.decision.distance)}"
        labels = [
            replace(label, text=found) if label.text.startswith("option ") else label
            for label in drawn.labels
        ]
        return replace(drawn, labels=tuple(labels))
    if stage is Stage.ACT:
        return drawn
    options, sizes, words = _marks(cycle, stage)
    places = [picture.position_of(int(option)) for option in options]
    kept = [n for n, place in enumerate(places) if place is not None]
    points = np.array([places[n] for n in kept], np.float32).reshape(-1, 3)
    labels = [_label(words[n], places[n]) for n in kept if n < len(words) and places[n] is not None]
    axes = [label for label in drawn.labels if not _is_of_path(label, cycle)]
    return replace(
        drawn,
        votes=tuple(level[:0] for level in drawn.votes),
        voters=points,
        voter_sizes=sizes[kept].astype(np.float32),
        labels=(*labels, *axes),
    )


def _marks(cycle: Cycle, stage: Stage) -> tuple[NDArray[np.int64], NDArray[np.float64], list[str]]:
    """Options to mark, how big, and words for the first few of them."""
    if stage is Stage.ASSIMILATE:
        options, first = np.unique(cycle.options, return_index=True)
        order = np.argsort(first)[:_MARKED]
        rows = first[order]
        moved = np.abs(cycle.after - cycle.before)[rows]
        sizes = 0.4 + 0.5 * moved / max(float(moved.max(initial=0.0)), 1e-300)
        words = [f"{cycle.options[row]}: {change_of(cycle, row)}" for row in rows[:TOLD_CHANGES]]
        return options[order], sizes, words
    kind = GrowthKind.CREATED if stage is Stage.ACCOMMODATE else GrowthKind.REMOVED
    events = cycle.of(kind)[:_MARKED]
    if kind is GrowthKind.CREATED:
        options = [event.option for event in events]
        words = [f"new option {option}" for option in options]
    else:  # What is gone has no place any more; what took it over has.
        events = tuple(event for event in events if event.parent >= 0)
        options = [event.parent for event in events]
        words = [f"{event.option} merged into {event.parent}" for event in events]
    return np.array(options, np.int64), np.full(len(options), _MARK_SIZE), words[:TOLD_CHANGES]


def _decided(cycle: Cycle) -> int:
    return int(cycle.decision.path[-1]) if len(cycle.decision.voters) else -1


def _is_of_path(label: Label, cycle: Cycle) -> bool:
    path = cycle.decision.path
    if len(path) == 0:
        return False
    return label.text.startswith(f"option {path[-1]} ") or label.text == f"root {path[0]}"


def _label(text: str, point: NDArray[np.float32] | None) -> Label:
    assert point is not None
    return Label(text, (float(point[0]), float(point[1]), float(point[2]) + 0.5), _SIDES)
