"""A single step of a held run, walked through stage by stage."""

from playwright.sync_api import expect

from ao2viz.recording.cycle import Stage
from ao2viz.training.states import RunStatus
from tests.browser.conftest import Open


def test_a_step_is_walked_through_stage_by_stage(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.field("Steps").fill("5000000")
    window.wait(lambda: window.view.form.steps == 5_000_000, "the number of steps")
    window.press("Start")
    window.wait(lambda: window.view.run.n_steps > 600, "steps", 120)
    window.press("Pause")
    window.wait(lambda: window.view.run.status is RunStatus.PAUSED, "the pause")
    held = window.view.run.n_steps
    current = window.page.locator("[aria-current=step]")
    for stage, words in (
        (Stage.SAMPLE, "The agent sees: cart position"),
        (Stage.FIND, "The most similar of"),
        (Stage.ACT, "It earned 1.00, and"),
        (Stage.ACCOMMODATE, "was made"),
        (Stage.ASSIMILATE, "changed"),
        (Stage.CLEANSE, "No option was let go in this step."),
    ):
        if stage is Stage.FIND:
            window.page.keyboard.press("Shift+N")
        else:
            window.press("Stage")
        window.wait(
            lambda: window.view.walk is not None and window.view.walk.stage is stage,  # noqa: B023
            stage.value,
        )
        window.wait_for_text(words)
        expect(current).to_have_text(stage.value)
        assert window.view.run.n_steps == held + 1
    window.press("Stage")
    window.wait(lambda: window.view.run.n_steps == held + 2, "the next step")
    window.wait(
        lambda: window.view.walk is not None and window.view.walk.stage is Stage.SAMPLE,
        "its first stage",
    )
    window.page.keyboard.press("q")
    window.wait(lambda: current.count() == 0, "the stages to give way to another step")
