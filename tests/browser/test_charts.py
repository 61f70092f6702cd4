"""The charts: a cursor that goes with the replay, and tables to take away."""

import csv

from tests.browser.conftest import Open


def test_the_cursor_and_the_slider_go_with_the_replay(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Charts").click()
    window.press("First step")
    window.wait_for_text("Step 0: margin")
    chart = window.page.locator(".ao-episode svg")
    cursor = window.page.locator(".ao-cursor-line")
    box = chart.bounding_box()

    def offset() -> tuple[float, float]:
        place = cursor.bounding_box()
        return abs(place["x"] - box["x"]), abs(place["y"] - box["y"])

    window.wait(lambda: offset()[0] < 4 and offset()[1] < 6, "the cursor at the start")
    # The slider below the chart is what a click on the chart would be.
    tracks = window.page.locator(".mantine-Slider-root:visible").all()
    track = next(t for t in tracks if t.bounding_box()["y"] > box["y"])
    place = track.bounding_box()
    assert abs(place["x"] - box["x"]) < 8
    assert abs(place["width"] - box["width"]) < 12
    window.page.mouse.click(place["x"] + place["width"] / 2, place["y"] + place["height"] / 2)
    last = window.view.transport.last
    window.wait(lambda: abs(window.view.transport.position - last / 2) < last / 20, "the middle")
    shown = window.view.transport.position
    window.wait_for_text(f"Step {shown}: margin")
    middle = box["x"] + box["width"] * shown / last
    window.wait(lambda: abs(cursor.bounding_box()["x"] - middle) < 6, "the cursor in the middle")


def test_tables_are_taken_away_as_csv(dashboard, open_window: Open, tmp_path):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Charts").click()
    with window.page.expect_download() as waited:
        window.press("Episode CSV")
    waited.value.save_as(tmp_path / "episode.csv")
    assert waited.value.suggested_filename.startswith("CartPole-v1-episode")
    with (tmp_path / "episode.csv").open(encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(window.view.episode)
    assert float(rows[2]["margin"]) == window.view.episode.decisions[2].margin


def test_training_is_drawn_over_episodes_when_asked(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Charts").click()
    window.wait(lambda: window.page.locator(".js-plotly-plot").count() >= 2, "the charts")
    window.choose("Over", "episodes")
    window.wait(
        lambda: "episodes" in window.page.locator(".js-plotly-plot .xtitle").all_text_contents(),
        "the other axis",
    )
