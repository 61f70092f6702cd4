"""Where a worker lives: inline for tests, in a thread, or in a process of its own."""

import contextlib
import dataclasses
import multiprocessing
import pickle
import queue
import signal
import threading
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Protocol

from ao2viz.training.serve import serve
from ao2viz.training.states import RunCommand, RunStatus, Start
from ao2viz.training.updates import RunUpdate
from ao2viz.training.worker import Worker

_CLOSING_S = 5.0  # Then a process is ended; saving is all or nothing, so nothing breaks.


class Runner(Protocol):
    """Takes commands and shows the newest update; neither ever waits for the worker."""

    def submit(self, command: RunCommand) -> None:
        """Hands a command over; the update says what came of it."""
        ...

    def latest(self) -> RunUpdate:
        """The newest update; the same object until there is a newer one."""
        ...

    def close(self) -> None:
        """Ends the run without saving, and whatever it ran in."""
        ...


class InlineRunner:
    """Works when told to, in the caller's thread."""

    def __init__(self) -> None:
        self.worker = Worker()
        self._update = RunUpdate()
        self._shown = -1

    def submit(self, command: RunCommand) -> None:
        """Handles a command at once."""
        self.worker.handle(command)

    def advance(self, budget_s: float = 0.05) -> float | None:
        """Lets the worker work; see `Worker.advance`."""
        return self.worker.advance(budget_s)

    def run_until_held(self) -> RunUpdate:
        """Works until there is nothing more to do without a command."""
        while self.advance() is not None:
            pass
        return self.latest()

    def latest(self) -> RunUpdate:
        """An update made for this call if anything may have changed."""
        if self.worker.status is RunStatus.RUNNING or self.worker.changes != self._shown:
            self._shown = self.worker.changes
            self._update = self.worker.update()
        return self._update

    def close(self) -> None:
        """Lets go of the environment."""
        self.worker.close()


class ThreadRunner:
    """Works in a thread of this process, sharing its interpreter."""

    def __init__(self) -> None:
        self._inbox: queue.SimpleQueue[RunCommand | None] = queue.SimpleQueue()
        self._update = RunUpdate()
        self._thread = threading.Thread(target=self._work, name="ao2viz training", daemon=True)
        self._thread.start()

    def submit(self, command: RunCommand) -> None:
        """See `Runner`."""
        self._inbox.put(command)

    def latest(self) -> RunUpdate:
        """See `Runner`."""
        return self._update

    def close(self) -> None:
        """See `Runner`."""
        self._inbox.put(None)
        self._thread.join(_CLOSING_S)

    def _work(self) -> None:
        try:
            serve(Worker(self._update.run_id), self._receive, self._publish)
        except Exception as error:
            message = f"The training worker failed: {type(error).__name__}: {error}"
            self._publish(_failed(self._update, message))

    def _receive(self, wait_s: float | None) -> Sequence[RunCommand] | None:
        commands: list[RunCommand] = []
        try:
            item = self._inbox.get(timeout=wait_s) if wait_s != 0 else self._inbox.get_nowait()
            while item is not None:
                commands.append(item)
                item = self._inbox.get_nowait()
        except queue.Empty:
            return commands
        return None

    def _publish(self, update: RunUpdate) -> None:
        self._update = update  # One overwriting slot; assigning a name is atomic.


class ProcessRunner:
    """Works in a process of its own, so that neither interpreter waits for the other.

    A worker that dies shows as a failed run; the next Start makes a new one. Programs that use
    this need `if __name__ == "__main__":` around their own start, as always with processes.
    """

    def __init__(self) -> None:
        self._update = RunUpdate()
        self._is_closing = False
        self._spawn()

    @property
    def pid(self) -> int | None:
        """The id of the worker's process."""
        return self._process.pid

    def submit(self, command: RunCommand) -> None:
        """See `Runner`."""
        if self._has_ended.is_set():
            if not isinstance(command, Start):
                self._update = _failed(self._update, _GONE)
                return
            self._let_go()
            self._spawn()
        self._outgoing.put(command)

    def latest(self) -> RunUpdate:
        """See `Runner`."""
        return self._update

    def close(self) -> None:
        """See `Runner`."""
        self._is_closing = True
        self._outgoing.put(None)
        self._let_go()

    def _spawn(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._has_ended = threading.Event()  # Set once the pipe says so; the process lags behind.
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(
            target=_work_in_process,
            args=(theirs, self._update.run_id),
            name="ao2viz training",
            daemon=True,  # Ends with this process, whatever happens.
        )
        self._process.start()
        theirs.close()  # Else its end would go unnoticed.
        # All that is sent goes through one thread: a pipe takes one sender, and may be full.
        self._outgoing: queue.SimpleQueue[RunCommand | str | None] = queue.SimpleQueue()
        self._threads = [
            threading.Thread(target=work, args=(self._pipe, self._outgoing), name=name, daemon=True)
            for work, name in ((self._pump, "ao2viz updates"), (_post, "ao2viz commands"))
        ]
        for thread in self._threads:
            thread.start()

    def _let_go(self) -> None:
        """Waits until the process has ended, makes it end if need be, and cleans up after it."""
        self._process.join(_CLOSING_S)
        for end in (self._process.terminate, self._process.kill):
            if self._process.is_alive():
                end()
                self._process.join(_CLOSING_S)
        self._outgoing.put(None)
        for thread in self._threads:
            thread.join(_CLOSING_S)
        self._pipe.close()

    def _pump(
        self, pipe: Connection, outgoing: "queue.SimpleQueue[RunCommand | str | None]"
    ) -> None:
        """Keeps the newest update and asks for the next."""
        try:
            while True:
                update = pickle.loads(pipe.recv_bytes())
                _freeze(update)
                self._update = update
                outgoing.put(_NEXT)
        except (EOFError, OSError):
            self._has_ended.set()
            if not self._is_closing:
                self._update = _failed(self._update, _GONE)


def _post(pipe: Connection, outgoing: "queue.SimpleQueue[RunCommand | str | None]") -> None:
    """Sends until it has sent None, which tells the worker to go."""
    with contextlib.suppress(OSError):
        while True:
            item = outgoing.get()
            pipe.send(item)
            if item is None:
                return


_NEXT = "next"
_GONE = (
    "The training process ended unexpectedly. What it learned since it was last saved is lost; "
    "start a new run, or go on from a saved file."
)


class _Outbox:
    """Sends the newest update from a thread of its own, one for each that was asked for.

    Training never waits for it: an update that was not sent yet is replaced by the next.
    """

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._newest: bytes | None = None
        self._wake = threading.Condition()
        self._is_wanted = True
        threading.Thread(target=self._send, name="ao2viz outbox", daemon=True).start()

    def put(self, update: RunUpdate) -> None:
        message = pickle.dumps(update, pickle.HIGHEST_PROTOCOL)
        with self._wake:
            self._newest = message
            self._wake.notify()

    def want(self) -> None:
        with self._wake:
            self._is_wanted = True
            self._wake.notify()

    def _send(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._is_wanted and self._newest is not None)
                message, self._newest, self._is_wanted = self._newest, None, False
            assert message is not None
            try:
                self._pipe.send_bytes(message)
            except OSError:
                return  # Nobody is left to see it; `receive` notices too.


def _work_in_process(pipe: Connection, runs_before: int) -> None:
    # Ctrl-C in a terminal reaches every process; the one that started us decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    outbox = _Outbox(pipe)

    def receive(wait_s: float | None) -> Sequence[RunCommand] | None:
        commands: list[RunCommand] = []
        try:
            while pipe.poll(wait_s):
                item = pipe.recv()
                if item is None:
                    return None
                if item == _NEXT:
                    outbox.want()
                else:
                    commands.append(item)
                    wait_s = 0.0
        except (EOFError, OSError):
            return None  # The process that started us is gone.
        return commands

    serve(Worker(runs_before), receive, outbox.put)


def _failed(update: RunUpdate, message: str) -> RunUpdate:
    return dataclasses.replace(
        update,
        status=RunStatus.FAILED,
        message=message,
        is_error=True,
        steps_per_s=0.0,
        eta_s=None,
    )


def _freeze(update: RunUpdate) -> None:
    """Arrays come out of a pipe writable; what is shown must not be."""
    if update.forest is not None:
        for array in vars(update.forest).values():
            if hasattr(array, "flags"):
                array.flags.writeable = False
    if update.learned is not None:
        for array in update.learned.state.values():
            array.flags.writeable = False
