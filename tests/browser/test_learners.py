"""The paper's learners behind a live run, in a real browser."""

import csv

from tests.browser.conftest import Open, Window


def open_pendulum(window: Window, tab: str) -> None:
    """Watches a new run of two Pendulum episodes."""
    window.choose("Environment", "Pendulum-v1")
    window.field("Steps").fill("400")
    window.page.keyboard.press("Enter")
    window.press("Start")
    window.wait(lambda: len(window.view.history) == 2, "two episodes", patience_s=120)
    window.page.get_by_role("tab", name=tab).click()


def test_learners_are_laid_behind_a_live_run_and_told_in_words(dashboard, open_window: Open):
    window = open_window(dashboard)
    open_pendulum(window, "Charts")
    window.wait(lambda: window.page.locator(".js-plotly-plot").count() >= 2, "the charts")
    window.page.get_by_text("Behind it: the paper's learners").click()
    window.page.get_by_label("AO2 paper", exact=True).check()
    returns = window.page.locator(".js-plotly-plot").first
    window.wait(lambda: "you are here" in returns.inner_html(), "the mark of the run")
    assert [one.learner for one in window.view.learners.laid] == ["AO2 paper"]
    window.wait_for_text("You are at 400 steps")
    window.wait_for_text("as good after")
    window.choose("Over", "episodes")
    window.wait_for_text("choose steps to see them")
    window.wait(lambda: "you are here" not in returns.inner_html(), "the mark to go")


def test_compare_tells_of_all_and_hands_over_their_curves(dashboard, open_window: Open, tmp_path):
    window = open_window(dashboard)
    window.page.get_by_role("tab", name="Compare").click()
    window.wait_for_text("There are no learning curves of CartPole-v1; there are of CartPole-v0")
    open_pendulum(window, "Compare")
    window.wait_for_text("You are at 400 steps")
    window.press("Draw in Charts")
    learners = window.view.learners
    assert len(learners.known) > 1
    window.wait(lambda: window.view.learners.laid == learners.known, "all learners")
    window.page.get_by_role("button", name="Take from Charts").wait_for()
    with window.page.expect_download() as waited:
        window.page.get_by_role("button", name="Curves CSV").locator("visible=true").click()
    waited.value.save_as(tmp_path / "curves.csv")
    with (tmp_path / "curves.csv").open(encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    assert {row["environment"] for row in rows} == {"Pendulum-v1"}
    laid = {one.learner for one in window.view.learners.laid}
    assert {row["learner"] for row in rows} == laid
