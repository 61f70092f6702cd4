"""Forests and decisions made by hand, for everything that only reads them."""

from dataclasses import replace

import numpy as np

from ao2viz.core.decision import NO_OPTION, DecideBy, Decision, Plan
from ao2viz.core.forest import Forest, ForestView
from ao2viz.envs.task import TaskSpec, describe, make_env


def cartpole() -> TaskSpec:
    return describe(make_env("CartPole-v1"))


def pendulum() -> TaskSpec:
    return describe(make_env("Pendulum-v1"))


def random_view(
    n: int, roots: int = 3, deepest: int = 4, seed: int = 0, n_features: int = 4, n_actions: int = 2
) -> ForestView:
    """A random forest of n options, the first `roots` of them roots."""
    rng = np.random.default_rng(seed)
    parents, depths = np.full(n, NO_OPTION), np.zeros(n, np.int64)
    for option in range(roots, n):
        shallow = np.flatnonzero(depths[:option] < deepest)
        parents[option] = rng.choice(shallow)
        depths[option] = depths[parents[option]] + 1
    return ForestView(
        values=rng.normal(size=(n, n_features)),
        parents=parents,
        depths=depths,
        weights=rng.normal(size=(n, n_actions)),
        visits=rng.integers(0, 30, (n, n_actions)),
        born=np.arange(n),
        is_alive=np.ones(n, np.bool_),
        links=np.empty((0, 2), np.int64),
        attention=np.ones(n_features),
        revision=n,
    )


def first(view: ForestView, n: int) -> ForestView:
    """The forest when it had only its first n options."""
    names = ("values", "parents", "depths", "weights", "visits", "born", "is_alive")
    return replace(view, revision=n, **{name: getattr(view, name)[:n] for name in names})


def with_parents(view: ForestView, parents: np.ndarray, is_alive: np.ndarray) -> ForestView:
    """The forest with another structure; depths follow."""
    depths = np.zeros(len(parents), np.int64)
    for option in np.flatnonzero(is_alive):
        walker = option
        while parents[walker] != NO_OPTION:
            walker = parents[walker]
            depths[option] += 1
    return replace(
        view, parents=parents, depths=depths, is_alive=is_alive, revision=view.revision + 1
    )


def small_view() -> ForestView:
    """Roots 0 and 3; 0 has the children 1 and 2, and 1 the child 4."""
    forest = Forest(4, 2, np.array([1.0, 0.5, 10.0, 0.5]))
    for value, parent in (
        ((0.0, 0.0, 0.0, 0.0), NO_OPTION),
        ((0.1, 0.0, 0.05, 0.0), 0),
        ((-0.1, 0.0, -0.05, 0.0), 0),
        ((2.0, 0.0, 0.1, 0.0), NO_OPTION),
        ((0.1, 0.2, 0.06, 0.0), 1),
    ):
        forest.add(np.array(value), parent, step=7)
    forest.columns.weights[:5] = [[1, 2], [3, 4], [6, 5], [0, 0], [90.5, 92.25]]
    forest.columns.visits[:5] = [[1, 1], [2, 9], [4, 0], [0, 0], [3, 12]]
    return forest.view()


SEEN = np.array([0.1, 0.2, 0.08, 0.0])


def decision(**changes: object) -> Decision:
    """A vote of options 4 and 1 of `small_view`, seeing SEEN; push right wins."""
    view = small_view()
    paths = np.array([[0, 1, 4], [0, 1, NO_OPTION]])
    distances = view.distances_to(SEEN)
    made = Decision(
        observation=SEEN,
        action=1,
        decide_by=DecideBy.VOTE,
        action_values=np.array([87.25, 91.5]),
        voters=np.array([4, 1]),
        shares=np.array([0.75, 0.25]),
        voter_weights=view.weights[[4, 1]],
        slopes=np.zeros((2, 4)),
        paths=paths,
        path_distances=np.where(paths == NO_OPTION, np.nan, distances[paths]),
        runner_up_option=1,
        runner_up_distance=float(distances[1]),
        explored=False,
        is_tie=False,
    )
    return replace(made, **changes)  # pyright: ignore[reportArgumentType]


def plan(**changes: object) -> Plan:
    """Push right, right, left: to option 1, then 4 twice; before, push left promised more."""
    made = Plan(
        actions=np.array([1, 1, 0]),
        states=np.array([SEEN, SEEN + 0.01, SEEN + 0.02]),
        rewards=np.array([1.0, 1.0, 1.0]),
        continues=np.array([1.0, 1.0, 1.0]),
        options=np.array([1, 4, 4]),
        worth=91.2,
        outlook_values=np.array([90.25, 90.0]),
    )
    return replace(made, **changes)  # pyright: ignore[reportArgumentType]


def no_options(**changes: object) -> Decision:
    """A decision while there is nothing to ask yet."""
    return decision(
        action_values=np.zeros(2),
        voters=np.empty(0, np.int64),
        shares=np.empty(0),
        voter_weights=np.empty((0, 2)),
        paths=np.empty((0, 0), np.int64),
        path_distances=np.empty((0, 0)),
        runner_up_option=NO_OPTION,
        runner_up_distance=np.nan,
        **{"explored": True, **changes},
    )
