"""Workers of a Ray cluster, for joblib."""

import contextlib
import logging
import os
from collections.abc import Iterator
from typing import Any

# Before Ray is imported: it would report its use otherwise.
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")

import ray
from joblib import register_parallel_backend
from ray.util.joblib.ray_backend import RayBackend

_NAME = "ao2viz-ray"
_QUIET: dict[str, Any] = {"log_to_driver": False, "logging_level": logging.ERROR}


class StreamingRayBackend(RayBackend):
    """Ray's, giving results as they come; it inherits from multiprocessing's that it could not."""

    supports_return_generator = True


@contextlib.contextmanager
def gather_ray(to_start: int, count: int | None, address: str | None) -> Iterator[tuple[Any, int]]:
    """A backend for joblib and how much it does at a time.

    Args:
        to_start: Processors of the cluster to start, if there is no address.
        count: How much to do at a time; None: as much as there are processors.
        address: HOST:PORT of the head node.

    Raises:
        OSError: If there is no cluster at the address.
    """
    register_parallel_backend(_NAME, StreamingRayBackend)
    logging.getLogger("ray").setLevel(logging.ERROR)
    if address is None:
        # joblib would do the work of a single worker in this very process.
        processors = max(to_start, 2)
        ray.init("local", num_cpus=processors, include_dashboard=False, **_QUIET)
    else:
        ray.init(address, **_QUIET)
    try:
        processors = int(ray.cluster_resources().get("CPU", 0))
        yield _NAME, max(min(count or processors, processors), 2)
    finally:
        ray.shutdown()
