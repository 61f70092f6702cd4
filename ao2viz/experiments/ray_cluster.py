"""Workers of a Ray cluster, for joblib.

Ray has a backend for joblib, but that gives no result before the last one is there, and hands out
work in turns, to busy workers too. Plain Ray tasks go to whoever is free.
"""

import contextlib
import logging
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from typing import Any

# Before Ray is imported: it would report its use otherwise.
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")

import ray
from joblib.parallel import ParallelBackendBase

_QUIET: dict[str, Any] = {"log_to_driver": False, "logging_level": logging.ERROR}


class RayTasks(ParallelBackendBase):
    """A backend of joblib: every batch of calls is a task for a processor of the cluster."""

    supports_retrieve_callback = True

    def __init__(self, count: int) -> None:
        super().__init__()
        self._count = count
        self._do: Any = ray.remote(_do)
        self._under_way: dict[Future[Any], Any] = {}

    # pyright takes the base class, which has no annotations, at its word.
    def effective_n_jobs(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, n_jobs: int
    ) -> int:
        """Tasks at a time."""
        return self._count

    def configure(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, n_jobs: int = 1, parallel: Any = None, **_: Any
    ) -> int:
        """Takes note of who asks; Ray needs no pool."""
        self.parallel = parallel
        return self._count

    def submit(
        self, func: Callable[[], Any], callback: Callable[[Any], object] | None = None
    ) -> "Future[Any]":
        """Sends a batch away; `callback` gets its future when it is done, or lost."""
        task = self._do.remote(func)
        future: Future[Any] = task.future()
        self._under_way[future] = task

        def tell(done: "Future[Any]") -> None:
            self._under_way.pop(done, None)
            if callback is not None:
                callback(done)

        future.add_done_callback(tell)
        return future

    def retrieve_result_callback(self, out: "Future[Any]") -> Any:
        """The result of a batch; raises what became of it instead."""
        return out.result()

    def abort_everything(self, ensure_ready: bool = True) -> None:
        """Drops what is under way."""
        for task in list(self._under_way.values()):
            ray.cancel(task, force=True)


@contextlib.contextmanager
def gather_ray(to_start: int, count: int | None, address: str | None) -> Iterator[tuple[Any, int]]:
    """A backend for joblib and how much it does at a time.

    Args:
        to_start: Processors of the cluster to start, if there is no address.
        count: How much to do at a time, at most; None: as much as there are processors.
        address: HOST:PORT of the head node.

    Raises:
        ConnectionError: If the cluster at the address does not let us in.
    """
    logging.getLogger("ray").setLevel(logging.ERROR)
    if address is None:
        ray.init("local", num_cpus=to_start, include_dashboard=False, **_QUIET)
    else:
        try:
            ray.init(address, **_QUIET)
        except ConnectionError as error:
            raise ConnectionError(
                f"{error}. If it asks for a token, set RAY_AUTH_MODE=token."
            ) from error
    try:
        processors = max(int(ray.cluster_resources().get("CPU", 0)), 1)
        at_a_time = min(count or processors, processors)
        yield RayTasks(at_a_time), at_a_time
    finally:
        ray.shutdown()


def _do(batch: Callable[[], Any]) -> Any:
    return batch()
