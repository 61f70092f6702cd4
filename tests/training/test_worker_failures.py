import pytest

from ao2viz import AO2
from ao2viz.training.states import Resume, RunStatus, Save, Start, TrainOn
from tests.training.workers import QUICK, forests_equal, held, prepared, run, start


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


def test_an_ended_run_goes_on_for_more_steps():
    worker = held(RunStatus.FINISHED)
    run_id = worker.update().run_id
    worker.handle(TrainOn(0))
    assert worker.status is RunStatus.FINISHED
    assert "at least one step to take, but got 0" in worker.update().message
    worker.handle(TrainOn(50))
    assert worker.status is RunStatus.RUNNING
    run(worker)
    update = worker.update()
    assert update.status is RunStatus.FINISHED, update.message
    assert (update.first_step, update.total_steps, update.n_steps) == (300, 50, 350)
    assert (update.run_id, len(update.seconds)) == (run_id, len(update.history))
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
