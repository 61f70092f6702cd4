"""Exporting from the page: the browser gets a file that reads back."""

import json

from tests.browser.conftest import Open


def test_an_export_downloads_a_file_that_reads_back(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Export").click()
    window.choose("For", "tables and programs")
    window.wait_for_text("a row for each recorded step".capitalize())
    window.choose("Format", "json")
    window.wait(lambda: window.view.export.format.value == "json", "the format")
    with window.page.expect_download(timeout=60_000) as waiting:
        window.press("Export")
    download = waiting.value
    assert download.suggested_filename == "CartPole-v1-episode-1.json"
    with open(download.path(), encoding="utf-8") as stream:
        document = json.load(stream)
    episode = window.view.episode
    assert len(document["episodes"]) == 1
    steps = document["episodes"][0]["steps"]
    assert [step["decision"]["action"] for step in steps] == episode.actions.tolist()
    window.wait_for_text("was handed to your browser")
