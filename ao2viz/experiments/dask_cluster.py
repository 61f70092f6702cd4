"""Workers of a Dask cluster, for joblib."""

import contextlib
import logging
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from importlib import metadata
from typing import Any

from distributed import Client, LocalCluster

# joblib has no public name for it.
from joblib._dask import DaskDistributedBackend

from ao2viz.experiments.provenance import provenance

_CONNECT_S = 15


class TellingDaskBackend(DaskDistributedBackend):
    """joblib's, but a task that Dask gives up is told; joblib would wait for it for ever."""

    def submit(self, func: Any, callback: Callable[[Any], object] | None = None) -> Any:
        """Sends a task to the cluster."""
        future = super().submit(func, callback)

        def tell(done: "Future[Any]") -> None:
            error = done.exception()
            if error is not None and callback is not None:
                callback(error)

        future.add_done_callback(tell)
        return future

    def retrieve_result_callback(self, out: Any) -> Any:
        """The result of a task; raises what Dask said about it instead."""
        if isinstance(out, BaseException):
            raise out
        return super().retrieve_result_callback(out)


@contextlib.contextmanager
def gather_dask(to_start: int, count: int | None, address: str | None) -> Iterator[tuple[Any, int]]:
    """A backend for joblib and how much it does at a time.

    Args:
        to_start: Workers to start, if there is no address.
        count: How much to do at a time, at most; None: as much as there are threads.
        address: HOST:PORT of the scheduler.

    Raises:
        OSError: If there is no scheduler.
        ValueError: If it has no workers, or some that lack this version of ao2viz.
    """
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # What matters, we say.
    with contextlib.ExitStack() as stack:
        if address is None:
            without_page: dict[str, Any] = {"dashboard_address": None}
            cluster: Any = LocalCluster(
                n_workers=to_start,
                threads_per_worker=1,
                silence_logs=logging.CRITICAL,
                **without_page,
            )
            address = stack.enter_context(cluster).scheduler_address
        client: Any = stack.enter_context(Client(address, timeout=_CONNECT_S))
        try:
            client.wait_for_workers(1, timeout=_CONNECT_S)
        except TimeoutError:
            raise ValueError(f"The Dask cluster at {address} has no workers; start some.") from None
        _check_versions(client)
        threads = sum(client.nthreads().values())
        yield TellingDaskBackend(client=client), min(count or threads, threads)


def _check_versions(client: Any) -> None:
    # A worker that cannot import what it is sent ends; the next one would be sent the same.
    here = provenance().version
    asked: dict[str, Any] = client.run(metadata.version, "ao2viz", on_error="return")
    for worker, version in asked.items():
        if isinstance(version, metadata.PackageNotFoundError):
            raise ValueError(f"The worker at {worker} has no ao2viz; install {here} there.")
        if version != here:
            raise ValueError(f"The worker at {worker} has ao2viz {version}, but this is {here}.")
