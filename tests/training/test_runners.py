import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from ao2viz import AO2, Preset
from ao2viz.training import serve
from ao2viz.training.runner import InlineRunner, ProcessRunner, ThreadRunner
from ao2viz.training.serve import LONGEST_S, MAX_INTERVAL_S, MIN_INTERVAL_S, SHORTEST_S, Pace
from ao2viz.training.states import (
    MAX_LEARNING,
    MIN_LEARNING,
    USUAL_LEARNING,
    Pause,
    Resume,
    RunEpisode,
    RunStatus,
    Save,
    SetSpeed,
    Start,
    Step,
)
from ao2viz.training.updates import RunUpdate
from ao2viz.training.worker import Worker

BACKGROUND = [ThreadRunner, ProcessRunner]


@pytest.fixture
def make():
    """Runners that are closed whatever happens."""
    made = []

    def make(kind):
        made.append(kind())
        return made[-1]

    yield make
    for runner in made:
        runner.close()


def wait_until(runner, is_there, timeout_s=60.0) -> RunUpdate:
    deadline = time.monotonic() + timeout_s
    while not is_there(update := runner.latest()):
        assert time.monotonic() < deadline, f"Still {update.status}: {update.message}"
        time.sleep(0.005)
    return update


def wait_for(runner, status: RunStatus) -> RunUpdate:
    return wait_until(runner, lambda update: update.status is status)


def assert_learned_alike(update: RunUpdate, agent: AO2) -> None:
    for name, array in vars(agent.forest).items():
        assert np.array_equal(getattr(update.forest, name), array), name
    assert np.array_equal(update.history, agent.history.to_array())


@pytest.mark.parametrize("kind", BACKGROUND)
@pytest.mark.parametrize("preset", Preset)
def test_the_same_forest_wherever_it_grows_and_however_it_is_held(make, kind, preset):
    agent = AO2("CartPole-v1", preset, seed=8).learn(1500)
    runner = make(kind)
    runner.submit(SetSpeed(300.0))  # Slow enough to be paused before it is through.
    runner.submit(Start("CartPole-v1", preset, seed=8, total_steps=1500))
    wait_for(runner, RunStatus.RUNNING)
    runner.submit(Pause())
    held = wait_for(runner, RunStatus.PAUSED)
    for n in range(1, 4):
        runner.submit(Step())
        wait_until(runner, lambda update, n=n: update.n_steps == held.n_steps + n)
    ended = len(runner.latest().history)  # A single step may have been the last of an episode.
    runner.submit(RunEpisode())
    wait_until(runner, lambda update: len(update.history) == ended + 1)
    assert wait_for(runner, RunStatus.PAUSED).episode.decisions
    runner.submit(SetSpeed(None))
    runner.submit(Resume())
    assert_learned_alike(wait_for(runner, RunStatus.FINISHED), agent)


@pytest.mark.parametrize("kind", BACKGROUND)
def test_a_reader_that_never_looks_holds_nothing_up(make, kind):
    runner = make(kind)
    runner.submit(Start("CartPole-v1", seed=8, total_steps=1500))
    time.sleep(0.5)
    update = wait_for(runner, RunStatus.FINISHED)
    assert_learned_alike(update, AO2("CartPole-v1", seed=8).learn(1500))


def test_a_reader_that_is_frozen_holds_nothing_up(tmp_path):
    """A stopped reader reads nothing at all; training goes on and saves, as told before."""
    code = (
        "import json, os, signal, time\n"
        "from pathlib import Path\n"
        "from ao2viz.training.runner import ProcessRunner\n"
        "from ao2viz.training.states import *\n"
        "if __name__ == '__main__':\n"
        "    runner = ProcessRunner()\n"
        "    runner.submit(SetSpeed(2000.0))\n"
        "    runner.submit(Start('CartPole-v1', total_steps=3000))\n"
        "    while runner.latest().status is not RunStatus.RUNNING: time.sleep(0.01)\n"
        "    print(runner.pid, flush=True)\n"
        "    os.kill(os.getpid(), signal.SIGSTOP)\n"
        "    while (update := runner.latest()).status is RunStatus.RUNNING: time.sleep(0.01)\n"
        "    print(json.dumps([update.status.value, update.n_steps]), flush=True)\n"
        "    signal.pause()\n"
    )
    script = tmp_path / "frozen.py"
    script.write_text(code)
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as reader:
        worker = int(reader.stdout.readline())
        deadline = time.monotonic() + 60
        # A worker with nothing left to do uses no processor.
        used, last = -1.0, 0.0
        while used != last:
            assert time.monotonic() < deadline
            time.sleep(1.0)
            used, last = last, _cpu_seconds(worker)
        at_work = last
        reader.send_signal(signal.SIGCONT)
        update = json.loads(reader.stdout.readline())
        assert update == ["finished", 3000]
        assert _cpu_seconds(worker) - at_work < 0.5, "It only worked once somebody looked."
        reader.kill()
    _wait_for_death(worker)


def _cpu_seconds(pid: int) -> float:
    with open(f"/proc/{pid}/stat") as stat:
        fields = stat.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _wait_for_death(pid: int) -> None:
    deadline = time.monotonic() + 10
    while _is_running(pid):
        assert time.monotonic() < deadline, f"Process {pid} was left behind."
        time.sleep(0.02)


def _is_running(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("kind", BACKGROUND)
def test_what_takes_long_is_shown_before_it_begins(make, kind):
    runner, seen = make(kind), []
    runner.submit(SetSpeed(300.0))
    runner.submit(Start("CartPole-v1", total_steps=300))
    while (update := runner.latest()).status is not RunStatus.FINISHED:
        if not seen or seen[-1] is not update:
            seen.append(update)
    statuses = [update.status for update in seen]
    assert RunStatus.PREPARING in statuses
    assert RunStatus.RUNNING in statuses


@pytest.mark.parametrize("kind", BACKGROUND)
def test_an_exploding_environment_shows_in_words_and_goes_on(make, kind, tmp_path):
    runner = make(kind)
    runner.submit(
        Start("tests.toy_envs:Exploding-v0", total_steps=200, overrides={"warmup_steps": 20})
    )
    update = wait_for(runner, RunStatus.FAILED)
    assert "RuntimeError: the corridor exploded" in update.message
    runner.submit(Save(tmp_path / "a.ao2"))
    wait_until(runner, lambda update: update.message.startswith("Saved to"))
    assert AO2.load(tmp_path / "a.ao2").num_timesteps == 59
    runner.submit(Resume())
    assert wait_for(runner, RunStatus.FINISHED).n_steps == 200


@pytest.mark.parametrize("kind", BACKGROUND)
def test_illegal_commands_are_answered_in_words(make, kind):
    runner = make(kind)
    runner.submit(Pause())
    update = wait_until(runner, lambda update: update.is_error)
    assert update.message == "Cannot pause while the run is idle."
    assert update.status is RunStatus.IDLE


@pytest.mark.parametrize("kind", BACKGROUND)
def test_commands_are_heard_while_training_is_slow(make, kind):
    runner = make(kind)
    runner.submit(SetSpeed(0.1))
    runner.submit(Start("CartPole-v1"))
    wait_for(runner, RunStatus.RUNNING)
    began = time.monotonic()
    runner.submit(Pause())
    wait_for(runner, RunStatus.PAUSED)
    assert time.monotonic() - began < 4, "It waited for the next step, ten seconds later."


def test_a_killed_worker_shows_as_failed_and_start_makes_a_new_one(make):
    runner = make(ProcessRunner)
    runner.submit(Start("CartPole-v1", total_steps=10**6))
    before = wait_until(runner, lambda update: update.n_steps > 300)
    os.kill(runner.pid, signal.SIGKILL)
    update = wait_for(runner, RunStatus.FAILED)
    assert update.message.startswith("The training process ended unexpectedly.")
    assert update.is_error
    assert len(update.forest) >= len(before.forest) - 50, "What was shown is still shown."
    runner.submit(Resume())
    assert runner.latest().status is RunStatus.FAILED
    runner.submit(Start("CartPole-v1", total_steps=400))
    update = wait_for(runner, RunStatus.FINISHED)
    assert update.run_id == before.run_id + 1
    assert_learned_alike(update, AO2("CartPole-v1").learn(400))


def test_closing_ends_the_process_even_at_work(make):
    runner = make(ProcessRunner)
    runner.submit(Start("CartPole-v1", total_steps=10**6))
    wait_for(runner, RunStatus.RUNNING)
    pid = runner.pid
    runner.close()
    assert not _is_running(pid)
    assert runner.latest().status is RunStatus.RUNNING, "Closing is no failure."


@pytest.mark.parametrize("ending", ["raise SystemExit", "import os; os.kill(os.getpid(), 9)"])
def test_the_process_never_outlives_the_one_that_started_it(tmp_path, ending):
    script = tmp_path / "leaver.py"
    # Waits for a picture: the library that draws would swallow the signal that ends the process.
    script.write_text(
        "import time\n"
        "from ao2viz.training.runner import ProcessRunner\n"
        "from ao2viz.training.states import *\n"
        "if __name__ == '__main__':\n"
        "    runner = ProcessRunner()\n"
        "    runner.submit(Start('CartPole-v1', total_steps=10**6))\n"
        "    while runner.latest().frame is None: time.sleep(0.01)\n"
        "    print(runner.pid, flush=True)\n"
        f"    {ending}\n"
    )
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.stderr == ""
    _wait_for_death(int(done.stdout))


def test_ctrl_c_in_the_terminal_is_left_to_the_program(make):
    runner = make(ProcessRunner)
    runner.submit(SetSpeed(500.0))
    runner.submit(Start("CartPole-v1", total_steps=500))
    wait_for(runner, RunStatus.RUNNING)
    os.kill(runner.pid, signal.SIGINT)
    assert wait_for(runner, RunStatus.FINISHED).n_steps == 500


def test_a_worker_that_breaks_shows_it(make, monkeypatch):
    def broken(self):
        raise ZeroDivisionError("a mistake of ours")

    monkeypatch.setattr(Worker, "update", broken)
    update = wait_for(make(ThreadRunner), RunStatus.FAILED)
    assert update.message == "The training worker failed: ZeroDivisionError: a mistake of ours"


def test_updates_come_at_most_ten_times_a_second():
    pace = Pace()
    assert pace.left_s(0.0) == 0
    pace.note(0.0, 0.001)
    assert pace.left_s(0.001 + 0.9 * MIN_INTERVAL_S) > 0
    assert pace.left_s(0.002 + MIN_INTERVAL_S) == 0


def test_updates_that_cost_much_come_rarely():
    pace = Pace()
    pace.note(0.0, 0.05)
    assert pace.interval_s == pytest.approx(0.05 * USUAL_LEARNING / (1 - USUAL_LEARNING))
    assert pace.left_s(0.9) > 0
    pace.note(2.0, 2.001)
    assert pace.interval_s == MIN_INTERVAL_S


def test_the_share_of_learning_decides_how_much_is_shown():
    intervals = []
    for learning in (MAX_LEARNING, USUAL_LEARNING, 0.8, MIN_LEARNING):
        pace = Pace(learning)
        pace.note(0.0, 0.02)
        intervals.append(pace.interval_s)
        # Updates take no more than the rest, unless that would be less often than it must be.
        assert 0.02 / (0.02 + pace.interval_s) <= 1 - learning + 1e-9
    assert intervals == sorted(intervals, reverse=True)
    assert intervals[0] > 10 * intervals[-1]
    assert Pace(MIN_LEARNING).interval_s == SHORTEST_S


def test_one_slow_update_does_not_hide_the_next_for_long():
    pace = Pace()
    pace.note(0.0, 5.0)
    assert pace.left_s(5.0 + MAX_INTERVAL_S) == 0


def test_showing_costs_training_little(monkeypatch):
    """Making updates, pictures included, takes the share of time that it may."""
    spent = 0.0
    make = Worker.update

    def timed(self):
        nonlocal spent
        began = time.thread_time()  # Other work on the machine is not in it.
        update = make(self)
        spent += time.thread_time() - began
        return update

    monkeypatch.setattr(Worker, "update", timed)
    worker = Worker()
    worker.handle(Start("CartPole-v1", total_steps=6000))
    while worker.status is RunStatus.PREPARING:
        worker.advance(0)
    began, spent = time.thread_time(), 0.0
    updates = []

    def receive(wait_s):
        return None if worker.status is RunStatus.FINISHED else []

    serve.serve(worker, receive, updates.append)
    took = time.thread_time() - began
    assert len(updates) >= 3
    assert spent < 3 * (1 - USUAL_LEARNING) * took


def test_inline_shows_what_is_there_now():
    runner = InlineRunner()
    runner.submit(Start("CartPole-v1", total_steps=100))
    assert runner.latest().status is RunStatus.PREPARING
    assert runner.latest() is runner.latest()
    assert runner.run_until_held().status is RunStatus.FINISHED


@pytest.mark.parametrize("learning", [MIN_LEARNING, 0.8, USUAL_LEARNING, MAX_LEARNING])
def test_learning_has_exactly_its_share_beside_a_big_forest(learning):
    pace, cost_s, began = Pace(learning), 0.25, 10.0
    for _ in range(2):
        pace.note(began, began + cost_s)
    next_one = began + cost_s / (1 - learning)
    assert pace.left_s(next_one - 1e-6) > 0
    assert pace.left_s(next_one + 1e-6) == 0
    pace.note(began=10.0, ended=70.0)
    assert pace.interval_s <= LONGEST_S


class Clockwork:
    """A worker without an agent, and the clock that its work moves on."""

    status, changes = RunStatus.RUNNING, 0

    def __init__(self, learning_share: float, cost_s: float) -> None:
        self.learning_share, self._cost_s = learning_share, cost_s
        self.now, self.learned_s, self.updates = 100.0, 0.0, 0

    def perf_counter(self) -> float:
        return self.now

    def update(self) -> RunUpdate:
        self.now += self._cost_s
        self.updates += 1
        return RunUpdate()

    def advance(self, budget_s: float) -> float:
        self.now += max(budget_s, 1e-4)  # Never less than a step.
        self.learned_s += max(budget_s, 1e-4)
        return 0.0

    def close(self) -> None:
        pass


@pytest.mark.parametrize(
    ("learning", "cost_s", "kept"),
    [
        (MIN_LEARNING, 0.05, MIN_LEARNING),
        (0.8, 0.05, 0.8),
        (MAX_LEARNING, 0.05, MAX_LEARNING),
        (MIN_LEARNING, 0.002, SHORTEST_S / (SHORTEST_S + 0.002)),  # Showing needs no more.
    ],
)
def test_the_loop_gives_learning_its_share(monkeypatch, learning, cost_s, kept):
    worker = Clockwork(learning, cost_s)
    monkeypatch.setattr(serve, "time", worker)
    serve.serve(worker, lambda _: [] if worker.now < 200 else None, lambda _: None)
    assert worker.learned_s / (worker.now - 100) == pytest.approx(kept, rel=0.01)
    assert worker.updates == pytest.approx(100 * (1 - kept) / cost_s, rel=0.1)
