"""Finding the most similar option: the forest's own search beside other exact ones.

Every rival answers the same queries over the same options, one after the other in one run, so
that the ratios hold on a busy machine. Answers are compared before anything is timed.

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
from ao2viz.core.forest import Forest
from ao2viz.core.search import ANY_ACTION, find_nearest

LEVELS = 16


@njit(cache=True)
def scan(points: NDArray[np.float64], queries: NDArray[np.float64], found: NDArray[np.int64]):
    """Brute force over one array a feature, as fast as a plain loop gets."""
    for q in range(queries.shape[0]):
        best, best_distance = -1, np.inf
        for i in range(points.shape[1]):
            d = 0.0
            for k in range(points.shape[0]):
                d += abs(points[k, i] - queries[q, k])
            if d < best_distance:
                best, best_distance = i, d
        found[q] = best


@njit(cache=True)
def walk(columns, root, queries, scratch, found):
    """One call of the forest's search per query, as the learner makes it."""
    ids, distances = np.empty(1, np.int64), np.empty(1)
    for q in range(queries.shape[0]):
        find_nearest(columns, root, queries[q], ANY_ACTION, np.inf, scratch, ids, distances)
        found[q] = ids[0]


def grow(points: NDArray[np.float64]) -> tuple[Forest, float]:
    """A forest of these points, inserted one by one as learning does; and seconds per insertion."""
    forest = Forest(points.shape[1], 1, np.ones(points.shape[1]))
    links = np.empty(MAX_LINKS, np.int64)
    find_parent(forest.columns, forest.heads[0], points[0], LEVELS, links)  # Compiles.
    started = time.perf_counter()
    for step, point in enumerate(points):
        parent, _ = find_parent(forest.columns, forest.heads[0], point, LEVELS, links)
        forest.add(point, int(parent), step)
    return forest, (time.perf_counter() - started) / len(points)


def seconds(answer: Callable[[], object], queries: int, repeats: int = 5) -> float:
    """Median seconds per query."""
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        answer()
        times.append(time.perf_counter() - started)
    return float(np.median(times)) / queries


def compare(name: str, points: NDArray[np.float64], queries: NDArray[np.float64]) -> str:
    """One row of the table: microseconds per query of each search."""
    forest, insertion = grow(points)
    tree = cKDTree(points)
    flat = faiss.IndexFlat(points.shape[1], faiss.METRIC_L1)
    flat.add(points.astype(np.float32))
    faiss.omp_set_num_threads(1)
    columns_first = np.ascontiguousarray(points.T)
    few = queries[: max(20, min(len(queries), 20_000_000 // len(points)))]
    ours, brute = np.empty(len(queries), np.int64), np.empty(len(few), np.int64)
    walk(forest.columns, forest.heads[0], queries, forest.scratch, ours)
    scan(columns_first, few, brute)
    np.testing.assert_array_equal(ours[: len(few)], brute)
    np.testing.assert_array_equal(ours, tree.query(queries, p=1)[1])
    timed = {
        "forest": seconds(
            lambda: walk(forest.columns, forest.heads[0], queries, forest.scratch, ours),
            len(queries),
        ),
        "brute": seconds(lambda: scan(columns_first, few, brute), len(few)),
        "tree": seconds(lambda: tree.query(queries, p=1), len(queries)),
        "one": seconds(lambda: [tree.query(q, p=1) for q in few[:200]], len(few[:200])),
        "faiss": seconds(lambda: flat.search(few.astype(np.float32), 1), len(few)),
    }
    cells = [f"{timed[key] * 1e6:,.1f}" for key in ("forest", "brute", "tree", "one", "faiss")]
    ratio = timed["forest"] / timed["tree"]
    return (
        f"| {name} | {len(points):,} | {' | '.join(cells)} | {ratio:.1f} | {insertion * 1e6:.1f} |"
    )


def visited_states(env_id: str, count: int) -> NDArray[np.float64]:
    """States that a learning agent really sees, in its own attention."""
    agent = ao2viz.AO2(env_id, seed=0)
    agent.learn(2 * count)
    view = agent.forest
    states = view.values[view.is_alive] * view.attention
    return np.random.default_rng(0).permutation(states)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", default="1000,10000,100000,1000000")
    parser.add_argument("--features", default="4,6")
    parser.add_argument("--queries", type=int, default=2000)
    arguments = parser.parse_args()
    print("µs per query; `forest` / cKDTree batched is the ratio; µs per insertion.\n")
    print(
        "| options | count | forest | brute force | cKDTree batched | cKDTree single | faiss L1",
        end="",
    )
    print(" | ratio | insertion |\n|---|---|---|---|---|---|---|---|---|")
    rng = np.random.default_rng(0)
    for d in map(int, arguments.features.split(",")):
        for n in map(int, arguments.sizes.split(",")):
            points, queries = rng.random((n, d)), rng.random((arguments.queries, d))
            print(compare(f"uniform, {d} features", points, queries), flush=True)
    for env_id in ("CartPole-v1", "Acrobot-v1"):
        states = visited_states(env_id, 10_000)
        held_out = len(states) // 5
        print(compare(f"{env_id}, visited", states[held_out:], states[:held_out]), flush=True)


if __name__ == "__main__":
    main()
