import io
import itertools
from dataclasses import dataclass

import numpy as np
import pytest
from PIL import Image

from ao2viz import AO2, DecideBy, Preset
from ao2viz.training.runner import InlineRunner
from ao2viz.training.states import (
    TRANSITIONS,
    Pause,
    Resume,
    RunEpisode,
    RunStatus,
    Save,
    SetDecideBy,
    SetSpeed,
    Start,
    Step,
    Stop,
    accepts,
)
from ao2viz.training.worker import Worker

QUICK = {"warmup_steps": 60}
ALL = [Start(), Resume(), Pause(), Step(), RunEpisode(), Stop(), SetSpeed(None),
       SetDecideBy(DecideBy.PATH)]  # fmt: skip


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


@pytest.mark.parametrize("status", RunStatus)
@pytest.mark.parametrize("command", ALL, ids=lambda c: type(c).__name__)
def test_the_worker_keeps_to_the_table(status, command, tmp_path):
    worker = held(status)
    before = worker.update()
    worker.handle(command)
    after = worker.update()
    target = TRANSITIONS.get((status, type(command)))
    assert accepts(status, type(command)) == (target is not None)
    if target is not None:
        assert after.status is target
        assert not after.is_error or after.message == before.message
    else:
        assert after.status is before.status
        assert after.is_error
        assert after.message.startswith("Cannot ")
        assert after.message.endswith(f" while the run is {status.value}.")
        assert (after.run_id, after.n_steps) == (before.run_id, before.n_steps)


@pytest.mark.parametrize("status", RunStatus)
def test_saving_is_possible_whenever_there_is_an_agent(status, tmp_path):
    worker = held(status)
    worker.handle(Save(tmp_path / "a.ao2"))
    assert worker.status is status
    if status in (RunStatus.IDLE, RunStatus.PREPARING):
        assert worker.update().is_error
        assert list(tmp_path.iterdir()) == []
    else:
        assert worker.update().message == f"Saved to {tmp_path / 'a.ao2'}."
        assert AO2.load(tmp_path / "a.ao2").num_timesteps == worker.update().n_steps


def test_a_run_from_start_to_finish():
    runner = InlineRunner()
    assert runner.latest().status is RunStatus.IDLE
    runner.submit(start())
    assert runner.latest().status is RunStatus.PREPARING
    update = runner.run_until_held()
    assert update.status is RunStatus.FINISHED
    assert (update.n_steps, update.total_steps, update.first_step) == (300, 300, 0)
    assert update.message == f"Finished: 300 steps, {len(update.forest)} options."
    assert update.spec.env_id == "Corridor-v0"
    assert (update.run_id, update.seed, update.preset) == (1, 3, Preset.ANTICIPATING)
    assert len(update.history) > 30
    runner.close()


@pytest.mark.parametrize("preset", Preset)
def test_a_run_learns_what_learn_learns(preset):
    agent = AO2("CartPole-v1", preset, seed=6).learn(900)
    runner = InlineRunner()
    runner.submit(Start("CartPole-v1", preset, seed=6, total_steps=900))
    update = runner.run_until_held()
    assert forests_equal(update.forest, agent.forest)
    assert np.array_equal(update.history, agent.history.to_array())


def test_however_a_run_is_held_it_learns_the_same():
    plain = prepared()
    run(plain)
    worker = prepared()
    for round_ in itertools.count():
        worker.advance(0.0005)
        worker.update()
        if worker.status is RunStatus.FINISHED:
            break
        worker.handle(Pause())
        for _ in range(round_ % 3):
            worker.handle(Step())
            worker.update()
        run(worker)
        worker.handle(RunEpisode() if round_ % 2 else Resume())
    assert round_ > 3
    assert forests_equal(worker.update().forest, plain.update().forest)
    assert worker.agent.to_saved().generator == plain.agent.to_saved().generator


def test_single_steps_are_counted():
    worker = held(RunStatus.PAUSED)
    for _ in range(3):
        worker.handle(Step())
    assert worker.update().n_steps == 0
    run(worker)
    update = worker.update()
    assert update.status is RunStatus.PAUSED
    assert (update.n_steps, update.episode_step, len(update.episode)) == (3, 3, 3)
    assert update.decision is update.episode.decisions[-1]
    assert update.episode.is_training


def test_the_last_single_step_finishes():
    worker = prepared(start(total_steps=2))
    worker.handle(Pause())
    worker.handle(Step())
    run(worker)
    assert worker.status is RunStatus.PAUSED
    worker.handle(Step())
    run(worker)
    assert worker.status is RunStatus.FINISHED


def test_a_step_while_the_last_one_settles_is_none_too_many():
    worker = prepared()
    while not worker.update().message.startswith("All steps taken"):
        worker.advance(0.01)
    worker.handle(Pause())
    worker.handle(Step())
    run(worker)
    assert (worker.status, worker.update().n_steps) == (RunStatus.FINISHED, 300)


def test_one_episode_runs_to_its_end_and_holds():
    worker = held(RunStatus.PAUSED)
    worker.handle(Step())
    run(worker)
    for finished in (1, 2):
        worker.handle(RunEpisode())
        assert worker.status is RunStatus.RUNNING
        run(worker)
        update = worker.update()
        assert update.status is RunStatus.PAUSED
        assert len(update.history) == finished
        assert update.episode.terminated or update.episode.truncated
        assert len(update.episode) == update.episode_step == update.history[-1, 2]


def test_pausing_within_one_episode_forgets_that_it_was_to_be_one():
    worker = held(RunStatus.PAUSED)
    worker.handle(RunEpisode())
    worker.handle(Pause())
    worker.handle(Resume())
    run(worker)
    assert worker.status is RunStatus.FINISHED


def test_an_episode_is_shown_only_while_nothing_runs():
    worker = prepared()
    while worker.update().n_steps < 100:
        worker.advance(0.001)
    assert worker.status is RunStatus.RUNNING
    assert worker.update().episode is None
    assert worker.update().decision is not None
    worker.handle(Pause())
    update = worker.update()
    assert len(update.episode.decisions) == update.episode_step


def test_the_picture_shows_the_latest_state():
    worker = held(RunStatus.PAUSED)
    assert worker.update().frame is None, "There is nothing to see before the first step."
    pictures = []
    for _ in range(2):
        worker.handle(Step())
        run(worker)
        update = worker.update()
        picture = Image.open(io.BytesIO(update.frame))
        assert (picture.format, picture.size) == ("JPEG", (60, 40))
        dark = np.flatnonzero(np.asarray(picture.convert("L"))[20] < 100)
        assert abs(dark.min() - 10 * update.episode.observations[-1][0]) <= 2
        pictures.append(update.frame)
    assert pictures[0] != pictures[1]


@pytest.mark.parametrize(("env_id", "draws"), [("Boxed1-v0", True), ("BadPicture-v0", False)])
def test_a_run_goes_on_without_pictures(env_id, draws):
    worker = prepared(start(f"tests.toy_envs:{env_id}"))
    while worker.advance(0.001) is not None:
        assert worker.update().frame is None
    assert worker.status is RunStatus.FINISHED
    worker = prepared(start(f"tests.toy_envs:{env_id}"))
    worker.handle(Pause())
    worker.handle(Step())
    run(worker)
    worker.update()
    if not draws:
        assert (
            worker.update().message == "BadPicture-v0 could not be drawn: OSError: no paint left."
        )


def test_stopping_keeps_the_agent():
    worker = prepared()
    worker.advance(0.002)
    worker.handle(Stop())
    update = worker.update()
    assert update.status is RunStatus.FINISHED
    assert update.message == f"Stopped after {update.n_steps:,} steps."
    assert update.forest is not None
    assert not accepts(update.status, Resume)


def test_stopping_while_preparing_leaves_nothing():
    worker = held(RunStatus.PREPARING)
    worker.advance(0)
    worker.handle(Stop())
    update = worker.update()
    assert (update.status, update.forest) == (RunStatus.IDLE, None)
    assert worker.advance(0.01) is None
    worker.handle(start())
    run(worker)
    assert worker.status is RunStatus.FINISHED


def test_a_new_run_gets_a_new_number_and_a_new_forest():
    worker = held(RunStatus.FINISHED)
    first = worker.update()
    worker.handle(start("CartPole-v1", total_steps=20))
    assert worker.update().run_id == first.run_id, "The old one is shown until the new one is."
    run(worker)
    second = worker.update()
    assert second.run_id == first.run_id + 1
    assert second.spec.env_id == "CartPole-v1"
    assert second.n_steps == 20


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (Start("Nowhere-v0"), "Could not make the environment 'Nowhere-v0'"),
        (Start("FrozenLake-v1"), "needs observations that are one row of numbers"),
        (Start("CartPole-v1", overrides={"gama": 1}), "no setting 'gama'"),
        (Start("CartPole-v1", seed=-1), "seed to be a whole number"),
        (Start("CartPole-v1", total_steps=0), "at least one step to take, but got 0"),
        (Start("CartPole-v1", resume_from="no.ao2"), "There is no file 'no.ao2'"),
    ],
)
@pytest.mark.parametrize("status", [RunStatus.IDLE, RunStatus.PAUSED])
def test_a_run_that_cannot_begin_changes_nothing(status, command, words):
    worker = held(status)
    before = worker.update()
    worker.handle(command)
    run(worker)
    after = worker.update()
    assert (after.status, after.run_id) == (status, before.run_id)
    assert after.is_error
    assert words in after.message
    if status is RunStatus.PAUSED:
        worker.handle(Resume())
        run(worker)
        assert worker.status is RunStatus.FINISHED


def test_an_exploding_environment_fails_the_run_and_loses_nothing(tmp_path):
    worker = prepared(start("tests.toy_envs:Exploding-v0"))
    run(worker)
    update = worker.update()
    assert update.status is RunStatus.FAILED
    assert update.is_error
    assert update.message == (
        "Exploding-v0 failed after 59 steps: RuntimeError: the corridor exploded. What was learned "
        "is kept: save it, or resume with a fresh episode."
    )
    assert update.n_steps == 59
    worker.handle(Save(tmp_path / "kept.ao2"))
    assert AO2.load(tmp_path / "kept.ao2").num_timesteps == 59
    episodes = len(update.history)
    worker.handle(Resume())
    run(worker)
    update = worker.update()
    assert (update.status, update.n_steps) == (RunStatus.FINISHED, 300)
    assert update.history[episodes, 2] <= 8, "The episode that exploded must not go on."


def test_numbers_that_are_none_fail_the_run():
    worker = prepared(start("tests.toy_envs:BadReward-v0"))
    run(worker)
    update = worker.update()
    assert update.status is RunStatus.FAILED
    assert "finite number as reward, but BadReward-v0 gave inf" in update.message


def test_a_saved_agent_goes_on(tmp_path):
    worker = held(RunStatus.FINISHED)
    worker.handle(Save(tmp_path / "a.ao2"))
    worker.handle(
        start(resume_from=tmp_path / "a.ao2", total_steps=50)  # Its own seed and settings count.
    )
    run(worker)
    update = worker.update()
    assert update.status is RunStatus.FINISHED, update.message
    assert (update.first_step, update.total_steps, update.n_steps) == (300, 50, 350)
    expected = AO2("tests.toy_envs:Corridor-v0", seed=3, **QUICK).learn(300).learn(50)
    assert forests_equal(update.forest, expected.forest)


def test_a_save_that_fails_says_so(tmp_path):
    (tmp_path / "file").write_text("in the way")
    worker = held(RunStatus.PAUSED)
    worker.handle(Save(tmp_path / "file" / "a.ao2"))
    update = worker.update()
    assert update.is_error
    assert update.message.startswith(f"Could not save to {tmp_path}/file/a.ao2: ")
    assert update.status is RunStatus.PAUSED


def test_who_decides_can_change_during_a_run():
    worker = prepared()
    assert worker.update().decide_by is DecideBy.VOTE
    worker.handle(SetDecideBy(DecideBy.PATH))
    run(worker)
    update = worker.update()
    assert update.decide_by is DecideBy.PATH
    assert update.decision.decide_by is DecideBy.PATH


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


def test_what_is_shown_cannot_be_changed():
    worker = held(RunStatus.PAUSED)
    worker.handle(Step())
    run(worker)
    with pytest.raises(ValueError, match="read-only"):
        worker.update().forest.attention[0] = 1
