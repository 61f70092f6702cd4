"""Finding the most similar options: the agent's own search beside other exact ones.

Every rival answers the same queries over the same options, one after the other in one run, so
that the ratios hold on a busy machine. Answers are compared before anything is timed. A second
table says what an option takes of memory.

    python -m benchmarks.search --sizes 1000,10000,100000,1000000 --features 4,6

Needs the extra `bench` (SciPy and faiss).
"""

import argparse
import time
from collections.abc import Callable

import faiss
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import ao2viz
from ao2viz.core.accommodation import MAX_LINKS, find_parent
from ao2viz.core.columns import allocate
from ao2viz.core.experience import allocate_experience
from ao2viz.core.forest import Forest
from ao2viz.core.imagination import allocate_imagination
from ao2viz.core.inference import count_ends
from ao2viz.core.search import ANY_ACTION, find_nearest
from ao2viz.envs.catalogue import CATALOGUE
from benchmarks.machine import describe_run

LEVELS = 16
COUNTS = (1, 16)


@njit(cache=True)
def scan(points: NDArray[np.float64], queries: NDArray[np.float64], found: NDArray[np.int64]):
    """Brute force over one array a feature, as fast as a plain loop gets; the nearest one."""
    for q in range(queries.shape[0]):
        best, best_distance = -1, np.inf
        for i in range(points.shape[1]):
            d = 0.0
            for k in range(points.shape[0]):
                d += abs(points[k, i] - queries[q, k])
            if d < best_distance:
                best, best_distance = i, d
        found[q, 0] = best


@njit(cache=True)
def ask(index, visits, queries, found):
    """One call of the agent's search per query, as the learner makes it."""
    ids, distances = np.empty(found.shape[1], np.int64), np.empty(found.shape[1])
    for q in range(queries.shape[0]):
        n = find_nearest(index, visits, queries[q], ANY_ACTION, np.inf, np.inf, ids, distances)
        for i in range(n):
            found[q, i] = ids[i]


def grow(points: NDArray[np.float64]) -> tuple[Forest, float]:
    """A forest of these points, inserted one by one as learning does; and seconds per insertion."""
    links = np.empty(MAX_LINKS, np.int64)

    def insert(forest: Forest, some: NDArray[np.float64]) -> None:
        for step, point in enumerate(some):
            columns = forest.columns
            parent, _ = find_parent(
                columns.scaled,
                columns.first_child,
                columns.next_sibling,
                forest.heads[0],
                point,
                LEVELS,
                links,
            )
            forest.add(point, int(parent), step)

    insert(Forest(points.shape[1], 1, np.ones(points.shape[1])), points[:100])  # Compiles.
    forest = Forest(points.shape[1], 1, np.ones(points.shape[1]))
    started = time.perf_counter()
    insert(forest, points)
    return forest, (time.perf_counter() - started) / len(points)


def seconds(answer: Callable[[], object], queries: int, repeats: int = 5) -> float:
    """Median seconds per query."""
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        answer()
        times.append(time.perf_counter() - started)
    return float(np.median(times)) / queries


def compare(name: str, points: NDArray[np.float64], queries: NDArray[np.float64]) -> None:
    """Prints the rows of the table: microseconds per query of each search, for each count."""
    forest, insertion = grow(points)
    tree = cKDTree(points)
    flat = faiss.IndexFlat(points.shape[1], faiss.METRIC_L1)
    flat.add(points.astype(np.float32))
    faiss.omp_set_num_threads(1)
    columns_first = np.ascontiguousarray(points.T)
    few = queries[: max(20, min(len(queries), 20_000_000 // len(points)))]
    single = queries[:200]
    places, visits = forest.columns.places, forest.columns.visits
    index_bytes = sum(array.nbytes for array in places) / len(points)
    brute = np.empty((len(few), 1), np.int64)
    scanned = seconds(lambda: scan(columns_first, few, brute), len(few))
    for k in COUNTS:
        ours = np.empty((len(queries), k), np.int64)
        answers = {
            "forest": lambda ours=ours: ask(places, visits, queries, ours),
            "tree": lambda k=k: tree.query(queries, k=k, p=1),
            "one by one": lambda k=k: [tree.query(query, k=k, p=1) for query in single],
            "faiss": lambda k=k: flat.search(few.astype(np.float32), k),
        }
        answers["forest"]()
        np.testing.assert_array_equal(ours[: len(few), :1], brute)
        np.testing.assert_array_equal(ours, tree.query(queries, k=[*range(1, k + 1)], p=1)[1])
        asked = (len(queries), len(queries), len(single), len(few))
        timed = [seconds(answer, n) for answer, n in zip(answers.values(), asked, strict=True)]
        cells = [f"{each * 1e6:,.1f}" for each in timed]
        cells.insert(1, f"{scanned * 1e6:,.1f}" if k == 1 else "")
        cells += [f"{timed[0] / timed[1]:.2f}", f"{insertion * 1e6:.1f}", f"{index_bytes:.0f}"]
        print(f"| {name} | {len(points):,} | {k} | {' | '.join(cells)} |", flush=True)


def visited_states(env_id: str, steps: int) -> NDArray[np.float64]:
    """Options of an agent that learned for so long, in its own attention, in their own order."""
    agent = ao2viz.AO2(env_id, seed=0)
    agent.learn(steps)
    view = agent.forest
    return view.values[view.is_alive] * view.attention


def weigh(env_id: str) -> str:
    """One row of the second table: bytes per option of each part of a forest."""
    agent = ao2viz.AO2(env_id, seed=0)
    d, a = agent.forest.values.shape[1], agent.forest.weights.shape[1]
    capacity = 1024
    parts = [
        allocate(capacity, d, a)[:-1],
        allocate_experience(capacity, a, d)[:-1],  # The last part, the laws, is no option's.
        allocate_imagination(capacity, a, count_ends(agent.config.voters, d)),
    ]
    cells = [sum(array.nbytes for array in part) // capacity for part in parts]
    rng = np.random.default_rng(0)
    forest, _ = grow(rng.random((100_000, d)))
    cells.append(sum(array.nbytes for array in forest.columns.places) // forest.n_rows)
    return f"| {env_id} | {d} | {a} | {' | '.join(map(str, cells))} | {sum(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", default="1000,10000,100000,1000000")
    parser.add_argument("--features", default="4,6")
    parser.add_argument("--queries", type=int, default=2000)
    arguments = parser.parse_args()
    print(describe_run("benchmarks.search"))
    print("µs per query for the k most similar; ratio: forest / cKDTree batched.\n")
    print("| options | count | k | forest | brute force | cKDTree batched | cKDTree single", end="")
    print(" | faiss L1 | ratio | insertion | index, bytes an option |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
    rng = np.random.default_rng(0)
    for env_id in ("CartPole-v1", "Pendulum-v1", "MountainCar-v0", "Acrobot-v1"):
        states = visited_states(env_id, 20_000)
        is_query = rng.random(len(states)) < 0.2
        compare(f"{env_id}, visited", states[~is_query], states[is_query])
    for d in map(int, arguments.features.split(",")):
        for n in map(int, arguments.sizes.split(",")):
            points, queries = rng.random((n, d)), rng.random((arguments.queries, d))
            compare(f"uniform, {d} features", points, queries)
    print("\nBytes per option of capacity; the index at 100,000 options.\n")
    print("| task | features | actions | structure | experience | imagination | index | together |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for env_id in CATALOGUE:
        print(weigh(env_id), flush=True)


if __name__ == "__main__":
    main()
