"""One option in full: what it stands for, expects and has tried, and why its weights are so.

A local, factual explanation of a part of the agent rather than of a decision.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.mind import Mind
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.agreement import Faithfulness
from ao2viz.explain.origin import Origin, explain_weight, tell_origin
from ao2viz.explain.uses import Use, find_uses
from ao2viz.explain.words import amounts, capitalised, count, number
from ao2viz.recording.episode import Episode


@dataclass(frozen=True, eq=False)
class WholeOption:
    """Everything that is known of one option."""

    option: int
    depth: int  # 0: a root.
    born: int  # The agent's step at which it was made.
    parents: tuple[int, ...]  # The one in the tree first.
    children: tuple[int, ...]
    value: NDArray[np.float64]  # [D] environment units.
    weights: NDArray[np.float64]  # [A]
    visits: NDArray[np.int64]  # [A] how often it tried each action.
    origins: tuple[Origin, ...]  # [A] what each weight rests on; empty: it imagines nothing.
    uses: tuple[Use, ...]  # Recorded steps at which it had a say.
    faithfulness: Faithfulness | None = None  # How often such answers agree with the agent.


def explain_option(mind: Mind, option: int, episodes: Sequence[Episode]) -> WholeOption:
    """All that is known of an option, and where in recorded episodes it had a say.

    Raises:
        ValueError: If there is no such living option.
    """
    view = mind.view
    if not (0 <= option < len(view.is_alive) and view.is_alive[option]):
        raise ValueError(
            f"There is no living option {option}; ids go from 0 to {len(view.is_alive) - 1}, and "
            f"{len(view):,} options are alive."
        )
    extra = view.links[view.links[:, 0] == option, 1]
    actions = range(view.weights.shape[1]) if mind.known is not None else ()
    return WholeOption(
        option=option,
        depth=int(view.depths[option]),
        born=int(view.born[option]),
        parents=tuple(view.parents_of(option).tolist()),
        children=(*view.children_of(option).tolist(), *extra.tolist()),
        value=view.values[option].copy(),
        weights=view.weights[option].copy(),
        visits=view.visits[option].copy(),
        origins=tuple(explain_weight(mind, option, action) for action in actions),
        uses=tuple(find_uses(episodes, option)),
    )


def tell_option(told: WholeOption, spec: TaskSpec) -> tuple[str, ...]:
    """What it stands for, what it expects of each action, and the story behind each weight."""
    place = f"at depth {told.depth}" if told.depth else "a root"
    stands = ", ".join(
        f"{feature.name} {shown}"
        for feature, shown in zip(spec.features, amounts(told.value, spec), strict=True)
    )
    lines = [
        f"Option {told.option}, {place}, made at step {told.born:,}, stands for {stands}.",
        f"It has {count(len(told.parents), 'parent')} and {len(told.children):,} "
        f"{'child' if len(told.children) == 1 else 'children'}, and had a say at "
        f"{count(len(told.uses), 'recorded step')}.",
    ]
    for action in np.argsort(-told.weights, kind="stable").tolist():
        lines.append(
            f"{capitalised(spec.action_names[action])}: expected to earn "
            f"{number(float(told.weights[action]), 5)}, tried "
            f"{count(int(told.visits[action]), 'time')}."
        )
    for origin in told.origins:
        lines += tell_origin(origin, spec)
    return tuple(lines)
