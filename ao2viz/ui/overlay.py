"""The decision drawn over the forest: the path, the other voters, the selection."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import Decision
from ao2viz.envs.task import TaskSpec
from ao2viz.ui.picture import Picture

SHARE_LEVELS = 3
"""Other voters' paths come in so many widths, the widest for the biggest shares."""


@dataclass(frozen=True, eq=False)
class Label:
    """A few words on the canvas."""

    text: str
    position: tuple[float, float, float]
    is_left: bool  # On the left of its option, else on the right: towards the middle.
    is_above: bool  # Above its option, else below: away from the other label.


@dataclass(frozen=True, eq=False)
class Overlay:
    """What lies over the picture; positions are scene coordinates."""

    path: NDArray[np.float32]  # [P, 3] root … most similar option; empty without a decision.
    path_sizes: NDArray[np.float32]  # [P] radii of the options on it.
    path_colors: NDArray[np.uint8]  # [P, 3] their own colours, kept in the middle.
    votes: tuple[NDArray[np.float32], ...]  # [V, 2, 3] segments for each level of share.
    voters: NDArray[np.float32]  # [K, 3] the other voters.
    voter_sizes: NDArray[np.float32]  # [K] by share.
    selected: NDArray[np.float32] | None  # [3]
    labels: tuple[Label, ...]


def overlay(decision: Decision | None, selected: int, picture: Picture, spec: TaskSpec) -> Overlay:
    """Works out the overlay; options that the picture lacks are left out."""
    path = _drawn(decision.path if decision is not None else np.empty(0, np.int64), picture)
    votes, voters, sizes = _votes(decision, picture)
    return Overlay(
        path=picture.positions[path],
        path_sizes=picture.sizes[path],
        path_colors=picture.colors[path],
        votes=votes,
        voters=voters,
        voter_sizes=sizes,
        selected=picture.position_of(selected),
        labels=_labels(decision, path, picture, spec) if decision is not None else (),
    )


def _drawn(options: NDArray[np.int64], picture: Picture) -> NDArray[np.int64]:
    inside = options[(options >= 0) & (options < len(picture.sizes))]
    return inside[picture.sizes[inside] > 0]


def _votes(
    decision: Decision | None, picture: Picture
) -> tuple[tuple[NDArray[np.float32], ...], NDArray[np.float32], NDArray[np.float32]]:
    segments: list[list[NDArray[np.float32]]] = [[] for _ in range(SHARE_LEVELS)]
    voters, sizes = [], []
    most = float(decision.shares.max()) if decision is not None and len(decision.shares) else 0.0
    for voter in range(1, len(decision.voters) if decision is not None and most > 0 else 0):
        assert decision is not None
        strength = float(decision.shares[voter]) / most
        path = _drawn(decision.path_of(voter), picture)
        if strength <= 0 or len(path) == 0:
            continue
        points = picture.positions[path]
        level = min(SHARE_LEVELS - 1, int(strength * SHARE_LEVELS))
        segments[level].append(np.stack([points[:-1], points[1:]], axis=1))
        voters.append(points[-1])
        sizes.append(0.45 + 0.3 * strength)
    empty = np.empty((0, 2, 3), np.float32)
    return (
        tuple(np.concatenate([empty, *level]) for level in segments),
        np.array(voters, np.float32).reshape(-1, 3),
        np.array(sizes, np.float32),
    )


def _labels(
    decision: Decision, path: NDArray[np.int64], picture: Picture, spec: TaskSpec
) -> tuple[Label, ...]:
    if len(path) == 0:
        return ()
    root, chosen = picture.positions[path[0]], picture.positions[path[-1]]
    left, right, _, _ = picture.box
    middle = (left + right) / 2
    is_root_above = bool(root[1] > chosen[1])
    name = f"option {path[-1]} → {spec.action_names[decision.action]}"
    labels = [Label(name, _spot(chosen), bool(chosen[0] > middle), not is_root_above)]
    if len(path) > 1:
        labels.append(Label(f"root {path[0]}", _spot(root), bool(root[0] > middle), is_root_above))
    return tuple(labels)


def _spot(point: NDArray[np.float32]) -> tuple[float, float, float]:
    return float(point[0]), float(point[1]), 0.5
