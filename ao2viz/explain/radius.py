"""A certified radius: how far what is seen can change, in any way, without changing the action.

Why it holds. Let q be the (scaled) observation, x any other at most r away in weighted L1, and
d_i(·) the distance to option i. Distances change by at most r, so option j can be the most
similar at x only if d_j(q) − r ≤ d_o(q) + r for the most similar option o at q: if it is *entered*,
r ≥ e_j = (d_j(q) − d_o(q)) / 2. Where j decides, the chosen action's lead over action b is a plane:
its value at x is at least its value m at q less r · g, g being the greatest of the differences of
slopes in any feature (Hölder's inequality for L1). So j *turns* to another action only if
r ≥ t_j = min over b of m / g; at once if m ≤ 0. The action can change at x only if the option that
decides there is entered and turned: nothing changes within min over j of max(e_j, t_j).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.mind import Mind

# Distances and planes are rounded; the radius gives way by more than all of that.
_SLACK = 1e-9


@dataclass(frozen=True)
class Certificate:
    """No observation less than `radius` away, in weighted L1, changes the action."""

    radius: float  # 0: a tie, or nothing is certain; inf: no option ever chooses otherwise.
    cell: float  # Up to here the same option stays the most similar, whatever changes.
    option: int  # The one that limits the radius; NO_OPTION if none does.
    asked: int  # Options whose planes were looked at.


def certify(mind: Mind, observation: NDArray[np.float64]) -> Certificate:
    """The certified radius around an observation [D]; takes about as long as a few decisions.

    Raises:
        ValueError: If the mind does not decide by one option's plane.
    """
    if not mind.is_piecewise_linear:
        raise ValueError(
            "Expected an agent that decides by path and does not think ahead: for other "
            "decisions nothing is certain at a distance."
        )
    alive = np.flatnonzero(mind.view.is_alive)
    if len(alive) == 0:
        return Certificate(0.0, 0.0, NO_OPTION, 0)
    decision = mind.decide(observation)
    distances = mind.view.distances_to(observation)[alive]
    entered = np.maximum((distances - decision.distance) / 2, 0.0)
    order = np.argsort(entered, kind="stable")
    cell = float(entered[order[1]]) if len(order) > 1 else np.inf
    if decision.is_tie:
        return Certificate(0.0, cell, int(decision.voters[0]), 1)
    radius, limiting, asked = np.inf, NO_OPTION, 0
    batch = 16
    while asked < len(order) and entered[order[asked]] < radius:
        some = order[asked : asked + batch]
        turned = turning_points(mind, observation, decision.action, alive[some])
        bounds = np.maximum(entered[some], turned)
        nearest = int(np.argmin(bounds))
        if bounds[nearest] < radius:
            radius, limiting = float(bounds[nearest]), int(alive[some[nearest]])
        asked += len(some)
        batch *= 2
    scale = float(np.abs(mind.view.attention * observation).sum()) + decision.distance
    return Certificate(
        radius=max(0.0, radius * (1 - _SLACK) - _SLACK * scale),
        cell=cell,
        option=limiting,
        asked=asked,
    )


def turning_points(
    mind: Mind,
    observation: NDArray[np.float64],
    action: int,
    options: NDArray[np.int64],
    other: int | None = None,
) -> NDArray[np.float64]:
    """[n] how far from an observation each option, if it decided, could first choose otherwise.

    In weighted L1, in any direction; inf where it never does. With `other`, only that action
    counts.
    """
    levels, slopes = mind.planes(options)
    gaps = mind.view.attention * observation - mind.forest.columns.scaled[options]
    values = levels + np.einsum("nad,nd->na", slopes, gaps)
    rivals = [a for a in range(values.shape[1]) if a != action and other in (None, a)]
    leads = values[:, [action]] - values[:, rivals]
    steepest = np.abs(slopes[:, [action]] - slopes[:, rivals]).max(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(leads > 0, leads / steepest, 0.0)
    return far.min(axis=1, initial=np.inf)
