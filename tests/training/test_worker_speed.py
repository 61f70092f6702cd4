from dataclasses import dataclass

import pytest

from ao2viz.training.states import Pause, RunStatus, SetSpeed
from ao2viz.training.worker import Worker
from tests.training.workers import prepared, run, start


@dataclass
class Clock:
    now: float = 0.0

    def __call__(self) -> float:
        return self.now


def test_speed_is_kept_and_can_be_lifted():
    clock = Clock()
    worker = Worker(clock=clock)
    worker.handle(start(total_steps=1000))
    while worker.status is RunStatus.PREPARING:
        worker.advance(1)
    worker.handle(SetSpeed(20.0))
    while clock.now < 5:
        wait_s = worker.advance(1)
        assert 0 < wait_s < 0.051
        clock.now += wait_s
    assert worker.update().n_steps == pytest.approx(100, abs=2)
    worker.handle(SetSpeed(None))
    run(worker)
    assert worker.status is RunStatus.FINISHED


@pytest.mark.parametrize("speed", [0, -5, float("nan"), float("inf")])
def test_speeds_that_cannot_be_are_refused(speed):
    worker = prepared()
    worker.handle(SetSpeed(speed))
    assert worker.update().is_error
    assert "more than 0 steps a second" in worker.update().message
    run(worker)
    assert worker.status is RunStatus.FINISHED


def test_progress_is_counted_while_running():
    clock = Clock()
    worker = Worker(clock=clock)
    worker.handle(start(total_steps=400))
    while worker.status is RunStatus.PREPARING:
        worker.advance(1)
    worker.handle(SetSpeed(100.0))
    for _ in range(100):
        clock.now += worker.advance(1)
        update = worker.update()
    assert update.steps_per_s == pytest.approx(100, rel=0.1)
    assert update.eta_s == pytest.approx((400 - update.n_steps) / 100, rel=0.1)
    worker.handle(Pause())
    assert worker.update().steps_per_s == 0
    assert worker.update().eta_s is None
