"""Settings and help: opened by button and by key, read, typed into, and closed again."""

import re
from pathlib import Path

from ao2viz.agent import AO2
from ao2viz.training.states import RunStatus
from ao2viz.ui.dialog_commands import Dialog
from tests.browser.conftest import Open, Window

GUIDE = Path(__file__).resolve().parents[2] / "docs" / "guide.md"


def opened(window: Window, key: str, dialog: Dialog) -> None:
    window.page.keyboard.press(key)
    window.wait(lambda: window.view.dialog is dialog, f"the dialog {dialog.value}")
    window.page.get_by_role("dialog").wait_for()
    if dialog is Dialog.HELP:
        window.page.locator(".ao-help kbd").first.wait_for()


def test_a_run_starts_with_typed_settings_and_changes_under_way(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.press("Settings")
    window.wait(lambda: window.view.dialog is Dialog.SETTINGS, "the settings")
    window.wait_for_text("Attention".upper())
    window.field("gamma").fill("3")
    window.wait_for_text("Expected gamma between 1e-06 and 1, but got 3.")
    window.field("gamma").fill("0.9")
    window.wait(lambda: window.view.form.settings == {"gamma": "0.9"}, "the setting")
    window.wait_for_text("changed")
    window.page.get_by_role("dialog").get_by_role("button", name="Close").first.click()
    window.wait_for_text("A new run differs from the defaults: gamma 0.9")
    window.field("Steps").fill("5000000")
    window.wait(lambda: window.view.form.steps == 5_000_000, "the number of steps")
    window.press("Start")
    window.wait(lambda: window.view.run.status is RunStatus.RUNNING, "the run", 120)
    assert window.view.run.config.gamma == 0.9

    opened(window, "Shift+S", Dialog.SETTINGS)
    window.field("epsilon_end").fill("0.5")
    window.wait(lambda: "epsilon_end" in window.view.form.settings, "the setting")
    window.press("Change the run")
    window.wait(lambda: window.view.run.config.epsilon_end == 0.5, "the change in the run")
    assert window.view.run.config.gamma == 0.9
    window.press("Defaults")
    window.wait(lambda: window.view.form.settings == {}, "the defaults")
    window.wait(lambda: window.field("gamma").input_value() == "0.995", "the default in the field")


def test_help_lists_exactly_the_keys_of_the_guide(dashboard, open_window: Open):
    window = open_window(dashboard)
    opened(window, "Shift+?", Dialog.HELP)
    shown = set(window.page.locator(".ao-help kbd").all_inner_texts())
    table = GUIDE.read_text("utf-8").split("## Keys")[1].split("\n## ")[0]
    rows = [line.split("|")[1:-1] for line in table.splitlines() if line.startswith("|")][2:]
    listed = [key.strip() for row in rows for cell in row[::2] for key in cell.split(",")]
    told = {key for key in listed if key}
    assert len(told) == len([key for key in listed if key]), "A key stands twice in the guide."
    assert shown == told
    words = window.page.locator(".ao-help").inner_text()
    assert re.search(r"pause or go on", words)
    assert "back to the main line" in words  # It cannot be asked for now, but it can be later.
    assert words.count("take over with") == len(window.view.spec.action_names) == 2
    window.page.keyboard.press("Escape")
    window.wait(lambda: window.view.dialog is None, "the dialog to close")
    window.wait(lambda: window.page.get_by_role("dialog").count() == 0, "the page to show it")
    window.choose("Watch", "Pendulum-v1")
    window.wait(lambda: window.view.source.stem == "Pendulum-v1", "the other agent")
    window.wait(lambda: window.view.replay.can_take_over, "its actions")
    window.press("Help")  # By key nothing opens while the list is in focus.
    window.page.get_by_role("dialog").wait_for()
    assert len(window.view.spec.action_names) == 5
    helped = window.page.locator(".ao-help")
    window.wait(lambda: helped.inner_text().count("take over with torque") == 5, "its actions")


def test_escape_leaves_a_dialog_also_from_within_a_field(dashboard, open_window: Open):
    window = open_window(dashboard)
    opened(window, "Shift+S", Dialog.SETTINGS)
    window.field("gamma").fill("0.9")
    # Viser's page applies what changes after what goes, and complains where one frame brings both.
    window.page.locator(".ao-setting .ao-mark").wait_for()
    window.page.keyboard.press("Escape")
    window.wait(lambda: window.view.dialog is None, "the dialog to close")
    assert window.view.form.settings == {"gamma": "0.9"}
    window.page.get_by_role("dialog").wait_for(state="hidden")
    opened(window, "Shift+L", Dialog.LIBRARY)
    window.field("Agent").click()
    window.page.get_by_role("option", name="Pendulum-v1").first.wait_for()
    window.page.keyboard.press("Escape")  # Closes the list.
    window.page.get_by_role("option", name="Pendulum-v1").first.wait_for(state="hidden")
    assert window.view.dialog is Dialog.LIBRARY
    window.page.keyboard.press("Escape")
    window.wait(lambda: window.view.dialog is None, "the dialog to close")


def test_an_agent_is_uploaded_watched_and_downloaded(
    dashboard, open_window: Open, shipped, tmp_path
):
    window = open_window(dashboard)
    opened(window, "Shift+L", Dialog.LIBRARY)
    source = tmp_path / "sent" / "sent.ao2"
    source.parent.mkdir()
    source.write_bytes((shipped / "Pendulum-v1.ao2").read_bytes())

    def upload():
        with window.page.expect_file_chooser() as chooser:
            window.press("Upload an agent (.ao2)")
        chooser.value.set_files(source)

    upload()
    kept = tmp_path / "sent.ao2"
    window.wait(kept.exists, "the uploaded file")
    assert kept.read_bytes() == source.read_bytes()
    window.wait_for_text("sent.ao2: Pendulum-v1")
    written = kept.stat().st_mtime_ns

    upload()
    window.wait_for_text("There is a file sent.ao2 already")
    window.press("Keep what is there")
    window.wait(lambda: window.view.upload is None, "the answer")
    assert kept.stat().st_mtime_ns == written

    source.write_bytes(b"PK no agent")
    upload()
    window.press("Replace the file")
    window.wait_for_text("Could not open 'sent.ao2'")
    assert kept.stat().st_mtime_ns == written

    window.wait(lambda: any(i.path == kept for i in window.view.shelf), "the shelf")
    window.choose("Agent", "sent")
    window.press("Watch it")
    window.wait(lambda: window.view.source == kept, "the uploaded agent")
    with window.page.expect_download() as download:
        window.press("Download it")
    assert Path(download.value.path()).read_bytes() == kept.read_bytes()


def test_the_agent_of_a_run_is_downloaded_while_it_learns(dashboard, open_window: Open, tmp_path):
    window = open_window(dashboard)
    window.field("Steps").fill("5000000")
    window.wait(lambda: window.view.form.steps == 5_000_000, "the number of steps")
    window.press("Start")
    window.wait(lambda: window.view.run.n_steps > 300, "steps", 120)
    opened(window, "Shift+L", Dialog.LIBRARY)
    with window.page.expect_download() as download:
        window.press("Download the run")
    assert download.value.suggested_filename.startswith("CartPole-v1-anticipating-seed0-")
    download.value.save_as(tmp_path / "copy.ao2")
    assert AO2.load(tmp_path / "copy.ao2").num_timesteps > 300
    assert window.view.run.status is RunStatus.RUNNING
    assert not list(tmp_path.glob(".*"))
