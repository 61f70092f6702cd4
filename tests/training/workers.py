"""Workers in every state, for tests."""

import numpy as np

from ao2viz.training.states import Pause, RunStatus, Start
from ao2viz.training.worker import Worker

QUICK = {"warmup_steps": 60}


def start(env_id="tests.toy_envs:Corridor-v0", total_steps=300, **more) -> Start:
    return Start(env_id, seed=3, total_steps=total_steps, overrides=QUICK, **more)


def prepared(command: Start | None = None) -> Worker:
    """A worker that has just begun to run."""
    worker = Worker()
    worker.handle(command or start())
    while worker.status is RunStatus.PREPARING:
        worker.advance(0.01)
    return worker


def held(status: RunStatus) -> Worker:
    """A worker in this status, with whatever it takes to get there."""
    if status is RunStatus.IDLE:
        return Worker()
    if status is RunStatus.PREPARING:
        worker = Worker()
        worker.handle(start())
        return worker
    worker = prepared(
        start("tests.toy_envs:Exploding-v0") if status is RunStatus.FAILED else start()
    )
    if status is RunStatus.PAUSED:
        worker.handle(Pause())
    elif status is not RunStatus.RUNNING:
        run(worker)
    assert worker.status is status
    return worker


def run(worker: Worker) -> None:
    while worker.advance(0.01) is not None:
        pass


def forests_equal(one, other) -> bool:
    return all(
        np.array_equal(a, b) for a, b in zip(vars(one).values(), vars(other).values(), strict=True)
    )
