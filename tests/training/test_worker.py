import io
import itertools

import numpy as np
import pytest
from PIL import Image

from ao2viz import AO2, DecideBy, Preset
from ao2viz.training.runner import InlineRunner
from ao2viz.training.states import (
    TRANSITIONS,
    ChangeSettings,
    Pause,
    Resume,
    RunEpisode,
    RunStatus,
    Save,
    SetDecideBy,
    SetShare,
    SetSpeed,
    Start,
    Step,
    Stop,
    TrainOn,
    accepts,
)
from tests.training.workers import forests_equal, held, prepared, run, start

ALL = [Start(), Resume(), Pause(), Step(), RunEpisode(), TrainOn(9), Stop(), SetSpeed(None),
       SetShare(0.8), SetDecideBy(DecideBy.PATH), ChangeSettings({"slip": 0.1})]  # fmt: skip


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


def test_every_training_episode_has_its_seconds():
    worker = prepared()
    run(worker)
    update = worker.update()
    assert len(update.seconds) == len(update.history) > 0
    assert (np.diff(update.seconds) >= 0).all()
    assert update.seconds[0] > 0


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


def test_who_decides_can_change_during_a_run():
    worker = prepared()
    assert worker.update().decide_by is DecideBy.PATH
    worker.handle(SetDecideBy(DecideBy.VOTE))
    run(worker)
    update = worker.update()
    assert update.decide_by is DecideBy.VOTE
    assert update.decision.decide_by is DecideBy.VOTE


def test_what_is_shown_cannot_be_changed():
    worker = held(RunStatus.PAUSED)
    worker.handle(Step())
    run(worker)
    with pytest.raises(ValueError, match="read-only"):
        worker.update().forest.attention[0] = 1


@pytest.mark.parametrize("learning", [0.49, 1.0, -1.0, float("nan")])
def test_a_share_that_is_none_changes_nothing(learning):
    worker = prepared()
    worker.handle(SetShare(0.8))
    worker.handle(SetShare(learning))
    update = worker.update()
    assert update.learning_share == worker.learning_share == 0.8
    assert update.message == (
        f"Expected from 50% to 99% of the time for learning, but got {learning}."
    )


def test_settings_change_in_the_middle_of_a_run_all_or_none():
    worker = prepared()
    worker.handle(ChangeSettings({"epsilon_end": 0.25, "slip": 0.1}))
    changed = worker.update()
    assert (changed.config.epsilon_end, changed.config.slip) == (0.25, 0.1)
    assert not changed.is_error
    for bad, words in (
        ({"slip": 0.2, "epsilon_end": 7.0}, "epsilon_end between 0 and 1, but got 7.0"),
        ({"slip": 0.2, "levels": 4}, "levels takes effect in a new run only"),
        ({"slip": 0.2, "colour": 1}, "no setting 'colour'"),
    ):
        worker.handle(ChangeSettings(bad))
        update = worker.update()
        assert update.is_error
        assert words in update.message
        assert update.config == changed.config
