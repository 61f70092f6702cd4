"""Training from the page: it grows, pauses, saves, reloads, and fails in words."""

from pathlib import Path

import pytest

from ao2viz.training.runner import ThreadRunner
from ao2viz.training.states import RunStatus
from ao2viz.ui.app import Dashboard
from tests import toy_envs
from tests.browser.conftest import Open, Window


def start(window: Window, steps: int) -> None:
    window.field("Steps").fill(str(steps))
    window.wait(lambda: window.view.form.steps == steps, "the number of steps")
    window.press("Start")
    window.wait(lambda: window.view.run.status is RunStatus.RUNNING, "the run", 120)


def test_a_forest_grows_pauses_is_saved_and_reloaded(dashboard, open_window: Open, tmp_path):
    window = open_window(dashboard)
    start(window, 5_000_000)
    assert window.view.source is None
    window.wait(lambda: window.view.run.n_steps > 1_000, "steps", 120)
    early = len(window.view.forest)
    window.wait(lambda: len(window.view.forest) > early > 0, "the forest to grow", 60)
    window.wait_for_text("steps/s")

    window.press("Pause")
    window.wait(lambda: window.view.run.status is RunStatus.PAUSED, "the pause")
    held = window.view.run.n_steps
    window.press("Step")
    window.wait(lambda: window.view.run.n_steps == held + 1, "a single step")
    window.press("Episode")
    window.wait(
        lambda: window.view.run.n_steps > held + 1 and window.view.run.status is RunStatus.PAUSED,
        "the end of the episode",
    )
    # A held run can be stepped through like a recorded episode.
    window.wait(lambda: window.view.transport.is_enabled, "the transport")
    last = window.view.transport.position
    window.press("Step back")
    window.wait(lambda: window.view.transport.position == last - 1, "the step before")
    assert window.view.decision is window.view.run.episode.decisions[last - 1]

    window.field("File name").fill("grown")
    window.wait(lambda: window.view.form.file_name == "grown", "the file name")
    window.press("Save")
    window.wait((tmp_path / "grown.ao2").exists, "the file")
    before = (tmp_path / "grown.ao2").stat().st_mtime_ns
    window.wait_for_text("grown.ao2")

    # Replacing a file needs a yes.
    window.press("Save")
    window.wait_for_text("There is a file grown.ao2 already")
    window.press("Keep the old one")
    window.wait(lambda: window.view.overwrite is None, "the answer")
    assert (tmp_path / "grown.ao2").stat().st_mtime_ns == before
    window.press("Save")
    window.press("Replace it")
    window.wait(lambda: (tmp_path / "grown.ao2").stat().st_mtime_ns != before, "the new file")

    window.choose("Watch", "grown")
    window.wait(lambda: window.view.source == tmp_path / "grown.ao2", "the saved agent")
    window.wait(lambda: window.view.forest is not None, "the saved forest")
    assert len(window.view.forest) == len(window.view.run.forest)
    assert (window.view.forest.values == window.view.run.forest.values).all()


def test_cartpole_is_trained_to_success(dashboard, open_window: Open):
    window = open_window(dashboard)
    start(window, 12_000)
    window.wait(lambda: window.view.run.status is RunStatus.FINISHED, "the end of the run", 150)
    returns = window.view.run.history[:, 1]
    assert returns[:20].mean() < 60
    assert returns.max() >= 400
    window.page.get_by_role("tab", name="Charts").click()
    window.wait(lambda: window.page.locator(".js-plotly-plot").count() >= 2, "the charts")
    window.wait_for_text("mean of 20")
    window.wait_for_text("Finished")


def test_a_saved_agent_is_trained_on_and_then_its_ended_run(dashboard, open_window: Open):
    window = open_window(dashboard)
    before = 1_500  # Of the agent that is shown first.
    window.field("Steps").fill("200")
    window.wait(lambda: window.view.form.steps == 200, "the number of steps")
    for more in (200, 400):
        window.press("Train on")
        window.wait(
            lambda more=more: (
                window.view.run.status is RunStatus.FINISHED
                and window.view.run.n_steps == before + more
            ),
            "the end of the steps",
            120,
        )
        assert window.view.source is None
    window.wait_for_text(f"Finished: {before + 400:,} steps")


def test_a_second_browser_joins_the_run(dashboard, open_window: Open):
    one = open_window(dashboard)
    start(one, 5_000_000)
    two = open_window(dashboard)
    assert two.view.source is None
    two.wait(lambda: two.view.run.n_steps > 300, "the run in the second browser", 60)
    two.choose("Watch", "CartPole-v1")
    two.wait(lambda: two.view.source is not None, "a recorded episode in the second browser")
    assert one.view.source is None
    two.press("Stop")
    one.wait(lambda: one.view.run.status is RunStatus.FINISHED, "the stop in the first browser")


@pytest.mark.parametrize("words", ["the corridor exploded"])
def test_an_exploding_environment_is_told_on_screen(shipped, tmp_path, open_window: Open, words):
    assert toy_envs.Corridor
    dashboard = Dashboard(
        port=0,
        shipped=shipped,
        folder=tmp_path,
        make_runner=ThreadRunner,
        env_ids=("tests.toy_envs:Exploding-v0",),
    )
    dashboard.start()
    try:
        window = open_window(dashboard)
        window.press("Start")
        window.wait(lambda: window.view.run.status is RunStatus.FAILED, "the failure", 120)
        window.wait_for_text(words)
        held = len(window.view.run.forest.parents)
        window.field("File name").fill("rescued")
        window.wait(lambda: window.view.form.file_name == "rescued", "the file name")
        window.press("Save")
        window.wait(lambda: Path(tmp_path / "rescued.ao2").exists(), "what was learned")
        assert held == len(window.view.run.forest.parents)
    finally:
        dashboard.stop()


def test_an_unknown_environment_is_refused_in_words(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.choose("Environment", "other")
    window.field("Gymnasium id").fill("Nowhere-v3")
    window.wait(lambda: window.view.form.custom_env == "Nowhere-v3", "the id")
    window.press("Start")
    window.wait_for_text("Nowhere", 60)
    window.wait(lambda: window.view.run.is_error, "the refusal", 60)
    window.field("Gymnasium id").fill("os:system")
    window.wait(lambda: window.view.form.custom_env == "os:system", "the id")
    window.press("Start")
    window.wait_for_text("colon imports code")
