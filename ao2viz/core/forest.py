"""The forest of options: a growable store with one owner, and the frozen view everyone reads."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ao2viz.core.arrays import take_array
from ao2viz.core.columns import add_row, allocate, insert, insert_all, walk_siblings
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.growth import GrowthEvent, GrowthKind
from ao2viz.core.index import check_index, forget_option, index_option, make_index, with_room
from ao2viz.core.search import ANY_ACTION, find_nearest

_FIRST_CAPACITY = 256


@dataclass(frozen=True, eq=False)
class ForestView:
    """The options of a forest, one row each, at one revision; row i is option id i.

    `N` counts options (cleansed ones included), `D` features, `A` actions, `L` extra links. The
    arrays cannot be written to.
    """

    values: NDArray[np.float64]  # [N, D] in the environment's own units.
    parents: NDArray[np.int64]  # [N] option ids, NO_OPTION at a root.
    depths: NDArray[np.int64]  # [N] 0 at a root.
    weights: NDArray[np.float64]  # [N, A] what each action is expected to earn.
    visits: NDArray[np.int64]  # [N, A] experiences that each weight rests on.
    born: NDArray[np.int64]  # [N] the agent's step at which the option was made.
    is_alive: NDArray[np.bool_]  # [N] False once cleansed; ids are never reused.
    links: NDArray[np.int64]  # [L, 2] extra (parent, child) pairs beside the tree.
    attention: NDArray[np.float64]  # [D] W of the paper's equation 1.
    revision: int  # Raised by every change of structure.

    def __len__(self) -> int:
        """How many options are alive."""
        return int(np.count_nonzero(self.is_alive))

    @property
    def best_actions(self) -> NDArray[np.int64]:
        """[N] the action each option prefers; ties go to the first."""
        return np.argmax(self.weights, axis=1)

    def best_action_of(self, option: int) -> int:
        """The action that one option prefers; of a big forest much sooner than all of them."""
        return int(np.argmax(self.weights[option]))

    def children_of(self, option: int) -> NDArray[np.int64]:
        """Ids of the options below this one in the tree, the oldest first."""
        return np.flatnonzero((self.parents == option) & self.is_alive)

    def parents_of(self, option: int) -> NDArray[np.int64]:
        """Every parent: the one in the tree first, then those of extra links."""
        spine = self.parents[option : option + 1]
        extra = self.links[self.links[:, 1] == option, 0]
        return np.concatenate([spine[spine != NO_OPTION], extra])

    def path_to(self, option: int) -> NDArray[np.int64]:
        """Ids from the root down to this option."""
        path = [option]
        while (parent := int(self.parents[path[-1]])) != NO_OPTION:
            path.append(parent)
        return np.array(path[::-1], np.int64)

    def distances_to(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """[N] weighted L1 distance from an observation to every option (paper, equation 1).

        Cleansed options get inf, so they never win an argmin.
        """
        gaps = np.abs(self.attention * observation - self.attention * self.values)
        return np.where(self.is_alive, gaps.sum(axis=1), np.inf)


class Forest:
    """The options of one agent. Mutable: exactly one owner; everyone else reads a `view()`.

    Rule: only this file and the compiled accommodation that calls `add_row` write to the
    structure columns (parents, children, is_alive, places). Weights and visits belong to
    assimilation.
    """

    def __init__(self, n_features: int, n_actions: int, attention: NDArray[np.float64]) -> None:
        self.n_features = n_features
        self.n_actions = n_actions
        self.attention = np.array(attention, np.float64)
        self.heads = np.array([NO_OPTION, 0], np.int64)  # First root, number of rows in use.
        self.columns = allocate(_FIRST_CAPACITY, n_features, n_actions)
        self.link_rows = np.empty((16, 2), np.int64)  # (parent, child), the first n_links in use.
        self.n_links = 0
        self.revision = 0

    @property
    def n_rows(self) -> int:
        """Options ever made, cleansed ones included."""
        return int(self.heads[1])

    @property
    def capacity(self) -> int:
        """Rows that fit before the arrays must grow."""
        return len(self.columns.parents)

    def reserve(self, rows: int) -> None:
        """Grows the arrays, by doubling, until `rows` more options fit; and the index for one."""
        capacity = self.capacity
        while capacity < self.n_rows + rows:
            capacity *= 2
        if capacity > self.capacity:
            grown = allocate(capacity, self.n_features, self.n_actions)
            for old, new in zip(self.columns[:-1], grown[:-1], strict=True):
                new[: self.n_rows] = old[: self.n_rows]
            self.columns = grown._replace(places=self.columns.places)
        places = with_room(self.columns.places)
        if places is not self.columns.places:
            self.columns = self.columns._replace(places=places)

    def add(self, value: NDArray[np.float64], parent: int, step: int) -> GrowthEvent:
        """Adds an option below `parent` (NO_OPTION: as a root of a new schema)."""
        self.reserve(1)
        value = np.asarray(value, np.float64)
        option = add_row(self.columns, self.heads, value, self.attention * value, parent, step)
        return self.adopt(int(option), step)

    def adopt(self, option: int, step: int) -> GrowthEvent:
        """Takes note of an option that compiled accommodation has just added."""
        self.revision += 1
        return GrowthEvent(step, GrowthKind.CREATED, option, int(self.columns.parents[option]))

    @property
    def links(self) -> NDArray[np.int64]:
        """[L, 2] extra (parent, child) pairs beside the tree."""
        return self.link_rows[: self.n_links]

    def reserve_links(self, rows: int) -> None:
        """Makes room for `rows` more extra links."""
        if self.n_links + rows > len(self.link_rows):
            grown = np.empty((2 * (self.n_links + rows), 2), np.int64)
            grown[: self.n_links] = self.links
            self.link_rows = grown

    def link(self, parent: int, child: int, step: int) -> GrowthEvent:
        """Makes `child` a further child of `parent`, beside its place in the tree.

        The two must be different living options, not linked yet; `check_invariants` tells.
        """
        self.reserve_links(1)
        self.link_rows[self.n_links] = parent, child
        self.n_links += 1
        self.revision += 1
        return GrowthEvent(step, GrowthKind.LINKED, child, parent)

    def nearest(
        self, observation: NDArray[np.float64], count: int = 1, action: int = ANY_ACTION
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Ids and distances of the `count` most similar options, closest first; exact.

        With an `action`, only among options that tried it. Fewer come back if there are fewer.
        """
        ids, distances = np.empty(count, np.int64), np.empty(count, np.float64)
        query = self.attention * np.asarray(observation, np.float64)
        places, visits = self.columns.places, self.columns.visits
        found = find_nearest(places, visits, query, action, np.inf, np.inf, ids, distances)
        return ids[:found], distances[:found]

    def remove(self, option: int, step: int, heir: int = NO_OPTION) -> list[GrowthEvent]:
        """Cleanses an option; its children move up to its parent. `heir` got its experience."""
        return self.remove_all(np.array([option]), np.array([heir]), step)

    def remove_all(
        self, options: NDArray[np.int64], heirs: NDArray[np.int64], step: int
    ) -> list[GrowthEvent]:
        """Cleanses these options at once; children move up to the nearest ancestor that stays.

        `heirs[i]` got the experience of `options[i]`, NO_OPTION: nobody did.
        """
        columns, n = self.columns, self.n_rows
        gone = np.zeros(n, np.bool_)
        for option in options.tolist():
            if not (0 <= option < n and columns.is_alive[option]) or gone[option]:
                raise ValueError(f"There is no living option {option} to remove.")
            gone[option] = True
        for option in options.tolist():
            forget_option(columns.places, columns.scaled, option)
        columns.is_alive[options] = False
        old = columns.parents[:n].copy()
        parents = np.where(gone, NO_OPTION, old)
        while (orphaned := (parents != NO_OPTION) & gone[parents]).any():
            parents[orphaned] = old[parents[orphaned]]
        self.heads[0] = NO_OPTION
        columns.parents[:n] = columns.first_child[:n] = columns.next_sibling[:n] = NO_OPTION
        insert_all(columns, self.heads, _parents_first(parents, columns.is_alive[:n]), parents)
        above, linked = self.links.T
        remaining = self.links[~gone[above] & ~gone[linked] & (parents[linked] != above)]
        self.n_links = len(remaining)
        self.link_rows[: self.n_links] = remaining
        self.revision += 1
        return [
            GrowthEvent(step, GrowthKind.REMOVED, *pair)
            for pair in zip(options.tolist(), heirs.tolist(), strict=True)
        ] + [
            GrowthEvent(step, GrowthKind.MOVED, child, int(parents[child]))
            for child in np.flatnonzero((parents != old) & ~gone).tolist()
        ]

    def set_attention(self, attention: NDArray[np.float64], step: int) -> GrowthEvent:
        """Changes the attention weights; every stored distance follows, the tree stays.

        Raises:
            ValueError: If the weights are not D finite numbers of at least 0.
        """
        attention = np.array(attention, np.float64)
        if attention.shape != (self.n_features,) or not (
            np.isfinite(attention).all() and (attention >= 0).all()
        ):
            raise ValueError(
                f"Expected {self.n_features} finite attention weights of at least 0, one per "
                f"feature, but got {attention}."
            )
        self.attention = attention
        n = self.n_rows
        self.columns.scaled[:n] = self.columns.values[:n] * attention
        self._index(np.flatnonzero(self.columns.is_alive[:n]))
        self.revision += 1
        return GrowthEvent(step, GrowthKind.ATTENTION, NO_OPTION, NO_OPTION)

    def begin_regrowth(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Uproots every option; each living one must then be replanted or merged away.

        Returns the parents as they were [N] and the living options, the oldest first. Extra links
        are dropped.
        """
        n, columns = self.n_rows, self.columns
        old_parents = columns.parents[:n].copy()
        columns.parents[:n] = NO_OPTION
        columns.first_child[:n] = NO_OPTION
        columns.next_sibling[:n] = NO_OPTION
        self.heads[0] = NO_OPTION
        self._index(np.empty(0, np.int64))
        self.n_links = 0
        self.revision += 1
        return old_parents, np.flatnonzero(columns.is_alive[:n])

    def replant(self, option: int, parent: int) -> None:
        """Puts an uprooted option back, below `parent` (NO_OPTION: as a root)."""
        self.reserve(0)
        insert(self.columns, self.heads, option, parent)
        index_option(self.columns.places, self.columns.scaled, option)

    def merge_away(self, option: int, heir: int, step: int) -> GrowthEvent:
        """Cleanses an uprooted option whose experience went to `heir`."""
        self.columns.is_alive[option] = False
        self.columns.weights[option] = 0.0
        return GrowthEvent(step, GrowthKind.REMOVED, option, heir)

    def get_state(self) -> dict[str, NDArray]:
        """Copies of the arrays from which `set_state` rebuilds everything else."""
        n, columns = self.n_rows, self.columns
        return {
            "values": columns.values[:n].copy(),
            "parents": columns.parents[:n].astype(np.int32),
            "is_alive": columns.is_alive[:n].copy(),
            "born": columns.born[:n].copy(),
            "weights": columns.weights[:n].copy(),
            "visits": columns.visits[:n].astype(np.int32),
            "links": self.links.astype(np.int32),
            "attention": self.attention.copy(),
            "revision": np.array(self.revision, np.int64),
        }

    def set_state(self, state: Mapping[str, NDArray]) -> None:
        """Rebuilds the forest that `get_state` was asked of; replaces this one.

        Raises:
            ValueError: If an array is missing, does not fit, or describes no forest.
        """
        n = len(state["values"]) if "values" in state else 0
        d, a = self.n_features, self.n_actions
        values = take_array(state, "values", (n, d), np.float64)
        parents = take_array(state, "parents", (n,), np.int32).astype(np.int64)
        is_alive = take_array(state, "is_alive", (n,), np.bool_)
        weights = take_array(state, "weights", (n, a), np.float64)
        visits = take_array(state, "visits", (n, a), np.int32)
        links = take_array(state, "links", (None, 2), np.int32)
        born = take_array(state, "born", (n,), np.int64)
        attention = take_array(state, "attention", (d,), np.float64)
        revision = take_array(state, "revision", (), np.int64)
        if not (np.isfinite(values).all() and np.isfinite(weights).all() and (visits >= 0).all()):
            raise ValueError("Expected finite values and weights, and visits of at least 0.")
        if ((parents < NO_OPTION) | (parents >= n)).any() or ((links < 0) | (links >= n)).any():
            raise ValueError(f"Expected parents and links among the {n} options.")
        order = _parents_first(parents, is_alive)
        fresh = Forest(d, a, np.zeros(d))
        fresh.set_attention(attention, 0)
        fresh.reserve(n)
        columns = fresh.columns
        columns.values[:n], columns.born[:n] = values, born
        columns.scaled[:n] = values * attention
        columns.is_alive[:n] = is_alive
        columns.weights[:n], columns.visits[:n] = weights, visits
        fresh.heads[1] = n
        insert_all(columns, fresh.heads, order, parents)
        fresh._index(np.flatnonzero(is_alive))
        above, below = links[:, 0], links[:, 1]
        is_wrong = ~(is_alive[above] & is_alive[below]) | (parents[below] == above)
        if is_wrong.any():
            raise ValueError(
                f"Expected extra links between living options, not {above[is_wrong][0]}."
            )
        fresh.reserve_links(len(links))
        fresh.link_rows[: len(links)] = links
        fresh.n_links = len(links)
        fresh.revision = int(revision)
        self.__dict__.update(fresh.__dict__)

    def view(self) -> ForestView:
        """A frozen copy of the forest as it is now."""
        n, columns = self.n_rows, self.columns
        return ForestView(
            *(
                _frozen(array)
                for array in (
                    columns.values[:n],
                    columns.parents[:n],
                    columns.depths[:n],
                    columns.weights[:n],
                    columns.visits[:n],
                    columns.born[:n],
                    columns.is_alive[:n],
                    self.links,
                    self.attention,
                )
            ),
            revision=self.revision,
        )

    def check_invariants(self) -> None:
        """Asks the forest whether it is sound.

        Raises:
            AssertionError: Naming the first invariant that does not hold.
        """
        n, columns = self.n_rows, self.columns
        alive = np.flatnonzero(columns.is_alive[:n])
        seen: list[int] = list(walk_siblings(columns, int(self.heads[0])))
        assert all(columns.parents[root] == NO_OPTION for root in seen), "A root has a parent."
        position = 0
        while position < len(seen):
            option = seen[position]
            position += 1
            children = list(walk_siblings(columns, int(columns.first_child[option])))
            for child in children:
                assert columns.parents[child] == option, f"Child {child} disowns {option}."
                assert columns.depths[child] == columns.depths[option] + 1, f"Depth of {child}."
            seen += children
            assert len(seen) <= n, "The tree has a cycle."
        assert sorted(seen) == alive.tolist(), "Tree and living options differ."
        np.testing.assert_array_equal(columns.scaled[:n], columns.values[:n] * self.attention)
        check_index(columns.places, columns.scaled[:n], columns.is_alive[:n])
        assert len(np.unique(self.links, axis=0)) == self.n_links, "A link is there twice."
        for parent, child in self.links:
            assert columns.is_alive[parent], f"A link leads from cleansed option {parent}."
            assert columns.is_alive[child], f"A link leads to cleansed option {child}."
            assert columns.parents[child] != parent, f"A link doubles the tree at {child}."
        assert np.isfinite(columns.weights[:n]).all(), "A weight is not finite."
        assert (columns.visits[:n] >= 0).all(), "A visit count is negative."

    def _index(self, options: NDArray[np.int64]) -> None:
        """Builds the index anew, of just these options."""
        self.columns = self.columns._replace(places=make_index(self.columns.scaled, options))


def _parents_first(parents: NDArray[np.int64], is_alive: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Living options ordered so that each comes after its parent.

    Raises:
        ValueError: If a parent is dead or the options form a cycle.
    """
    alive = np.flatnonzero(is_alive)
    depths = np.full(len(parents), -1)
    depths[alive] = 0
    has_parent = alive[parents[alive] != NO_OPTION]
    if not is_alive[parents[has_parent]].all():
        raise ValueError("Expected every parent to be a living option.")
    above = parents[has_parent]
    for _ in range(len(alive) + 1):
        deeper = depths[above] + 1
        if (depths[has_parent] == deeper).all():
            return alive[np.argsort(depths[alive], kind="stable")]
        depths[has_parent] = deeper
    raise ValueError("Expected trees, but the options' parents form a cycle.")


def _frozen(array: NDArray) -> NDArray:
    copy = array.copy()
    copy.flags.writeable = False
    return copy
