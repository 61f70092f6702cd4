"""What people type, read into numbers."""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ao2viz.envs.task import TaskSpec
from ao2viz.explain.words import count

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)


def read_state(text: str, spec: TaskSpec) -> NDArray[np.float64]:
    """An observation [D] from numbers in the units that people read, in the order of the features.

    Commas, semicolons or spaces separate them; units may follow.

    Raises:
        ValueError: If they are not D finite numbers; names the features that are expected.
    """
    plain = text.replace("−", "-")
    for feature in sorted(spec.features, key=lambda f: -len(f.unit)):
        if feature.unit:
            plain = re.sub(rf"(?<=[\d. ]){re.escape(feature.unit)}(?=[\s,;]|$)", " ", plain)
    parts = [part for part in re.split(r"[\s,;]+", plain) if part]
    if len(parts) != spec.n_features or not all(_NUMBER.fullmatch(part) for part in parts):
        raise ValueError(
            f"Expected {count(spec.n_features, 'number')}, separated by commas: "
            f"{', '.join(names(spec))}."
        )
    scales = np.array([feature.scale for feature in spec.features])
    state = np.array([float(part) for part in parts]) / scales
    if not np.isfinite(state).all():
        raise ValueError("Expected finite numbers.")
    return state


def tell_apart(names: Sequence[str]) -> tuple[str, ...]:
    """The names, those that occur twice with their number in front, for lists."""
    return tuple(
        name if list(names).count(name) == 1 else f"{i}: {name}"
        for i, name in enumerate(names, start=1)
    )


def names(spec: TaskSpec) -> list[str]:
    """The features with their units, in order."""
    return [f"{f.name} in {f.unit}" if f.unit else f.name for f in spec.features]
