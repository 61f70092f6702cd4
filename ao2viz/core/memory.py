"""What an agent remembers, row by row: its options, what followed each, and what it imagined.

The three grow together, and are saved and restored together.
"""

from typing import NamedTuple

import numpy as np

from ao2viz.core.arrays import Arrays, take_array
from ao2viz.core.config import MAX_VOTERS, AnticipatingConfig
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.experience import Experience, allocate_experience, expect_all
from ao2viz.core.forest import Forest
from ao2viz.core.imagination import Imagination, allocate_imagination, value_all
from ao2viz.core.law import MAX_DEGREE, Law, count_terms


class Memory(NamedTuple):
    """A forest and what belongs to each of its options; row i of every array is option i."""

    forest: Forest
    experience: Experience
    imagination: Imagination


def allocate_memory(forest: Forest, ends: int, law_degree: int = 0) -> Memory:
    """Nothing experienced or imagined yet; an imagination is shared out among `ends` options."""
    capacity, a = forest.capacity, forest.n_actions
    return Memory(
        forest,
        allocate_experience(capacity, a, forest.n_features, law_degree),
        allocate_imagination(capacity, a, ends),
    )


def reserve(memory: Memory) -> Memory:
    """Makes room for one more option in every array at once; the memory to go on with."""
    forest = memory.forest
    n, before = forest.n_rows, forest.capacity
    forest.reserve(1)
    if forest.capacity == before:
        return memory
    grown = allocate_memory(forest, memory.imagination.end_ids.shape[2])
    law = memory.experience.law
    for old, new in zip(
        (*memory.experience[:-1], *memory.imagination),
        (*grown.experience[:-1], *grown.imagination),
        strict=True,
    ):
        new[:n] = old[:n]
    return grown._replace(experience=grown.experience._replace(law=law))


def memory_to_arrays(memory: Memory) -> Arrays:
    """Copies of everything that `memory_from_arrays` needs."""
    n = memory.forest.n_rows
    imagination = memory.imagination._asdict()
    experience = memory.experience._asdict()
    del imagination["value"]  # Follows from the weights.
    del experience["expected"], experience["law"]  # The first follows from the second.
    law = memory.experience.law
    return {
        **memory.forest.get_state(),
        **{f"law_{name}": getattr(law, name).copy() for name in _law_names(law)},
        **{f"experience_{name}": array[:n].copy() for name, array in experience.items()},
        **{f"imagination_{name}": array[:n].copy() for name, array in imagination.items()},
    }


def memory_from_arrays(
    state: Arrays, n_features: int, n_actions: int, ends: int, config: AnticipatingConfig
) -> Memory:
    """The memory of an agent with this config that `memory_to_arrays` took apart.

    `ends` is that of `allocate_memory`.

    Raises:
        ValueError: If arrays are missing or do not fit one another.
    """
    forest = Forest(n_features, n_actions, np.zeros(n_features))
    forest.set_state(state)
    n = forest.n_rows
    # Files of format 1 keep room for more ends than are needed now; they may.
    ends = max(ends, state.get("imagination_end_ids", np.empty(0)).shape[-1])
    memory = allocate_memory(forest, min(ends, MAX_VOTERS), config.law_degree)
    columns = {"experience": memory.experience, "imagination": memory.imagination}
    for prefix, arrays in columns.items():
        for name, column in arrays._asdict().items():
            if name not in ("expected", "law", "value"):
                column[:n] = take_array(
                    state, f"{prefix}_{name}", (n, *column.shape[1:]), column.dtype
                )
    for name in ("end_ids", "story_end"):
        ids = getattr(memory.imagination, name)[:n]
        if ((ids < NO_OPTION) | (ids >= n)).any():
            raise ValueError(f"Expected option ids below {n} in imagination_{name}.")
    law = memory.experience.law
    for name in _law_names(law):
        array = getattr(law, name)
        array[:] = take_array(state, f"law_{name}", array.shape, array.dtype)
    if not all(np.isfinite(getattr(law, name)).all() for name in _law_names(law)):
        raise ValueError("Expected the numbers of the laws to be finite.")
    known = [count_terms(n_features, degree) for degree in range(1, MAX_DEGREE + 1)]
    room = law.coefficients.shape[1]
    if any(terms != 0 and (terms not in known or terms > room) for terms in law.n_terms.tolist()):
        raise ValueError(f"Expected laws of 0 or up to {room} terms, but got {law.n_terms}.")
    expect_all(memory.experience, n)
    value_all(memory.imagination.value, forest.columns.weights[:n], config.slip)
    return memory


def _law_names(law: Law) -> tuple[str, ...]:
    """The arrays that are saved of a law: none where the setting says that there is none."""
    return ("centre", "coefficients", "n_terms") if law.coefficients.size else ()
