"""Relevance: which features the choice between the actions depends on.

A feature may vary much and matter little for what to do: the cart's position, most of the time.
Attention by variance alone then spends its options on it. Weighting each feature by how steeply
the sought function changes along it is the gradient weighting of Kpotufe and Boularias (Gradient
Weights help Nonparametric Regressors, NeurIPS 2012); the function here is the advantage: an
action's weight less the mean of all actions'.
"""

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.compiled import compiled
from ao2viz.core.forest import Forest
from ao2viz.core.local_linear import (
    Workspace,
    broad_closeness,
    fit_planes,
    make_workspace,
)

_NEIGHBOURS = 24  # Options that a slope is fitted to.
_RIDGE = 0.05  # Steadies the slopes.
_SAMPLE = 512  # The most options at which slopes are taken; the mean needs no more.
_LIMIT = 4.0  # No feature counts more than this many times its share by variance, nor less.


def find_relevance(
    forest: Forest, steps: NDArray[np.int32], attention: NDArray[np.float64]
) -> NDArray[np.float64]:
    """How much more than its share by variance each feature deserves, [D], geometric mean 1.

    `steps` [C, A] is what `Imagination` has: only options all of whose weights were imagined are
    asked. `attention` [D] is the one that variance alone would give. Slopes are measured in its
    units, not in those of the forest's own attention: else each measurement would sharpen the
    last. All 1 while too little is known.
    """
    relevance = np.ones(len(attention))
    is_known = np.all(steps[: forest.n_rows] > 0, axis=1)
    options = np.flatnonzero(is_known & forest.columns.is_alive[: forest.n_rows])
    if len(options) < _NEIGHBOURS:
        return relevance
    weights = forest.columns.weights[options]
    sampled = np.unique(np.linspace(0, len(options) - 1, _SAMPLE).astype(np.int64))
    slopes = np.zeros(len(attention))
    _add_slopes(
        forest.columns.values[options] * attention,
        weights - weights.mean(axis=1, keepdims=True),
        # Where it often is counts more, but not so much that the rest is forgotten.
        np.sqrt(forest.columns.visits[options].sum(axis=1)),
        sampled,
        make_workspace(_NEIGHBOURS, len(attention), forest.n_actions),
        slopes,
    )
    matters = (slopes > 0.0) & (attention > 0.0)
    if matters.any():
        relative = slopes[matters] / np.exp(np.log(slopes[matters]).mean())
        relevance[matters] = np.clip(relative, 1.0 / _LIMIT, _LIMIT)
    return relevance


@compiled
def _add_slopes(
    scaled: NDArray[np.float64],
    advantages: NDArray[np.float64],
    loudness: NDArray[np.float64],
    sampled: NDArray[np.int64],
    work: Workspace,
    slopes: NDArray[np.float64],
) -> None:
    """Adds up how steeply the advantages [N, A] change along each feature of `scaled` [N, D].

    A local linear fit at each of the `sampled` options; over the actions, root of the sum of
    squares. The neighbours are found by looking at all: the index knows the forest's own
    attention only.
    """
    n_options, n_features = scaled.shape
    wanted = work.ids.shape[0]
    levels = np.empty(advantages.shape[1])
    for here in sampled:
        found = 0
        for other in range(n_options):
            gap = 0.0
            for d in range(n_features):
                gap += abs(scaled[other, d] - scaled[here, d])
            if found == wanted and gap >= work.distances[wanted - 1]:
                continue
            slot = found if found < wanted else wanted - 1
            found = min(found + 1, wanted)
            while slot > 0 and gap < work.distances[slot - 1]:
                work.distances[slot] = work.distances[slot - 1]
                work.ids[slot] = work.ids[slot - 1]
                slot -= 1
            work.distances[slot] = gap
            work.ids[slot] = other
        width = work.distances[found - 1]
        if width <= 0.0:
            continue
        for n in range(found):
            work.kernel[n] = broad_closeness(work.distances[n], width)
            for d in range(n_features):
                work.offsets[n, d] = (scaled[work.ids[n], d] - scaled[here, d]) / width
        fit_planes(advantages, found, width, _RIDGE, work, levels)
        for d in range(n_features):
            slopes[d] += loudness[here] * np.sqrt((work.slopes[:, d] ** 2).sum())
