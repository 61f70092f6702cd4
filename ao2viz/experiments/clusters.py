"""Where runs are done: in processes of this machine, or on the workers of a cluster.

All of it goes through joblib, which moves functions and arguments between our own processes and
keeps no files here. Dask and Ray have a module each, imported only by who asks for them.
"""

import contextlib
import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from enum import Enum
from typing import Any, TypeVar

from ao2viz.extras import need

ArgumentT = TypeVar("ArgumentT")
ResultT = TypeVar("ResultT")

_CONNECT_S = 15
_LOOK_S = 0.5


class Cluster(Enum):
    """Who does the work."""

    LOCAL = "local"
    """Processes of this machine, through loky."""
    DASK = "dask"
    """The workers of a Dask cluster."""
    RAY = "ray"
    """The workers of a Ray cluster."""


class WorkersLostError(RuntimeError):
    """A worker died, or could not do anything at all."""


@dataclass(frozen=True)
class Workers:
    """Those who wait for work; see `gather`."""

    backend: Any  # What `joblib.parallel_config` takes.
    count: int  # How much they do at a time.

    def map(
        self, function: Callable[[ArgumentT], ResultT], arguments: Iterable[ArgumentT]
    ) -> Generator[ResultT, None, None]:
        """The function of each argument, in the order in which they finish.

        An argument is taken from `arguments` when there is a worker for it. Leaving early, by an
        exception or by closing the iterator, drops what is under way.

        Raises:
            WorkersLostError: If a worker dies, cannot import what it needs, or the function raises.
        """
        from joblib import Parallel, delayed, parallel_config  # noqa: PLC0415  Optional.

        results: Any = None
        one_by_one: dict[str, Any] = {
            "batch_size": 1,  # Else what is finished would wait for what is not.
            "pre_dispatch": self.count,
        }
        try:
            with parallel_config(self.backend), _interrupts_held():
                parallel = Parallel(self.count, return_as="generator_unordered", **one_by_one)
                results = parallel(
                    delayed(_call)(function, argument, os.getpid()) for argument in arguments
                )
            yield from results
        except Exception as error:
            told = " ".join(str(error).split())
            raise WorkersLostError(f"{type(error).__name__}: {told}") from error
        finally:
            if results is not None:
                results.close()


def gather(
    cluster: Cluster, count: int | None = None, address: str | None = None
) -> AbstractContextManager[Workers]:
    """Workers for a `with`; those that were started for it end with it.

    Args:
        cluster: Which kind.
        count: How many; None: one for each processor, of this machine or of the cluster.
        address: Where the cluster is (HOST:PORT of Dask's scheduler or Ray's head node); None
            starts one on this machine.

    Raises:
        ValueError: If a library is missing, or there is an address but no cluster.
        OSError: If there is no cluster at the address.
    """
    need("experiments")
    if address is not None:
        if cluster is Cluster.LOCAL:
            raise ValueError("An address (--address) needs a cluster: --cluster dask or ray.")
        _check_address(address)
    match cluster:
        case Cluster.LOCAL:
            return contextlib.nullcontext(Workers("loky", count or _processors()))
        case Cluster.DASK:
            need("dask")
            from ao2viz.experiments.dask_cluster import gather_dask  # noqa: PLC0415  Optional.

            return _as_workers(gather_dask(count or _processors(), count, address))
        case Cluster.RAY:
            need("ray")
            from ao2viz.experiments.ray_cluster import gather_ray  # noqa: PLC0415  Optional.

            return _as_workers(gather_ray(count or _processors(), count, address))


def _check_address(address: str) -> None:
    """Makes sure that somebody listens there; Ray would try for minutes, and not quietly."""
    host, _, port = address.rpartition("//")[2].rpartition(":")
    if not (host and port.isdecimal() and int(port) < 2**16):
        raise ValueError(f"Expected --address HOST:PORT, but got {address!r}.")
    try:
        socket.create_connection((host, int(port)), timeout=_CONNECT_S).close()
    except OSError as error:
        raise OSError(f"There is no cluster at {address}: {error.strerror or error}.") from error


@contextlib.contextmanager
def _as_workers(gathered: AbstractContextManager[tuple[Any, int]]) -> Iterator[Workers]:
    with gathered as (backend, count):
        yield Workers(backend, count)


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Ctrl-C waits until the end, and never reaches a process that is started within.

    In a terminal it is sent to every process; only we decide what comes of it.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows.
        yield
        return
    from multiprocessing import resource_tracker  # noqa: PLC0415  Windows has no need of it.

    # Python's older ones let interrupts through when they start, and joblib would start it within.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _processors() -> int:
    from joblib import cpu_count  # noqa: PLC0415  Optional.

    return cpu_count()


def _call(function: Callable[[ArgumentT], ResultT], argument: ArgumentT, parent: int) -> ResultT:
    """What a worker does; one that we started on this machine does not outlive us."""
    if hasattr(os, "fork") and os.getppid() == parent:
        _follow(parent)
    return function(argument)


_is_watching = threading.Event()


def _follow(parent: int) -> None:
    """Ends this process soon after its parent, were that killed without a chance to say so."""
    if _is_watching.is_set():
        return
    _is_watching.set()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK_S)
        os._exit(1)

    threading.Thread(target=watch, name="ao2viz parent", daemon=True).start()
