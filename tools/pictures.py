"""Takes every picture of the guide anew, in both themes, from the real dashboard in a real browser.

    python -m tools.pictures [NAME …]

Without names all of them are taken. Each is written twice: the dark theme to docs/images, the light
one to docs/images/light. `make pictures` does the same.
"""

import argparse
import contextlib
import io
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlencode

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from ao2viz import AO2
from ao2viz.figures.palette import Theme
from ao2viz.recording.cycle import Stage
from ao2viz.training.runner import ThreadRunner
from ao2viz.training.states import RunStatus
from ao2viz.ui.app import Dashboard
from ao2viz.ui.dialog_commands import Dialog
from ao2viz.ui.frames import BLANK_JPEGS
from ao2viz.ui.view import View
from benchmarks.big_agents import make_agent_file
from benchmarks.chromium import launch

IMAGES = Path(__file__).resolve().parent.parent / "docs" / "images"
SIZE = {"width": 1440, "height": 810}
MOST_BYTES = 200_000
HUGE = "Acrobot-v1-100000"
"""An agent too big to come with the app: it is grown, in a minute, when its picture is taken."""
_PATIENCE_S = 180.0
_HINT_IS_GONE = """localStorage.setItem("viser-user:ao2viz", '{"hint_is_gone": true}')"""


class Visit:
    """One page on the dashboard, and what the dashboard thinks that it shows."""

    def __init__(self, page: Page, dashboard: Dashboard) -> None:
        self.page, self._dashboard = page, dashboard

    @property
    def view(self) -> View:
        """What it shows; there is one page at a time."""
        return next(iter(self._dashboard.views.values()))

    def wait(self, condition: Callable[[], bool], what: str) -> None:
        """Waits until something is so."""
        deadline = time.monotonic() + _PATIENCE_S
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"Waited in vain for {what}.")
            self.page.wait_for_timeout(100)

    def wait_for_text(self, words: str) -> None:
        """Waits until the page says something."""
        self.wait(lambda: words in self.page.locator("body").inner_text(), repr(words))

    def press(self, name: str) -> None:
        """Presses a button."""
        self.page.get_by_role("button", name=name, exact=True).first.click()

    def tab(self, name: str) -> None:
        """Opens a tab."""
        self.page.get_by_role("tab", name=name).click()

    def field(self, label: str):
        """The field beside a label."""
        named = self.page.locator("label", has_text=label).first
        return named.locator("xpath=ancestor::div[.//input][1]").locator("input:visible").first

    def fill(self, label: str, text: str) -> None:
        """Types into a field."""
        self.field(label).fill(text)
        self.page.keyboard.press("Enter")
        self.leave()

    def choose(self, label: str, option: str) -> None:
        """Picks from a list."""
        self.field(label).click()
        self.page.get_by_role("option", name=option).first.click()
        self.leave()

    def leave(self) -> None:
        """Leaves the field in focus, so that keys are keys again."""
        self.page.evaluate("document.activeElement.blur()")

    def hover_nowhere(self) -> None:
        """Puts the mouse where it lights nothing up."""
        self.page.mouse.move(SIZE["width"] / 2, 5)


Scene = Callable[[Visit], None]


def _dashboard(visit: Visit) -> None:
    visit.press("Decided")


def _first_visit(visit: Visit) -> None:
    visit.page.locator(".ao-hint").wait_for()


def _moments(visit: Visit) -> None:
    visit.tab("Moments")
    visit.fill("Stop when", "margin < 0.1")
    visit.press("Stop →")


def _branch(visit: Visit) -> None:
    visit.tab("Branch")
    visit.press("Push left")
    visit.wait(lambda: visit.view.replay.branch is not None, "the branch")


def _past(visit: Visit) -> None:
    visit.tab("Past")
    for _ in range(7):
        visit.press("Earlier")
        visit.page.wait_for_timeout(300)
    visit.wait(lambda: visit.view.back is not None, "the past")


def _state_space(visit: Visit) -> None:
    visit.tab("Forest")
    visit.choose("Layout", "state space")


def _cones(visit: Visit) -> None:
    visit.tab("Forest")
    visit.choose("Layout", "cones")


def _huge(visit: Visit) -> None:
    visit.tab("Forest")
    visit.wait_for_text("dots of one size")
    visit.page.wait_for_timeout(10_000)  # Drawn in software a frame takes half a second.


def _settings(visit: Visit) -> None:
    visit.press("Settings")
    visit.wait(lambda: visit.view.dialog is Dialog.SETTINGS, "the settings")
    visit.wait_for_text("ATTENTION")
    visit.field("gamma").fill("3")
    visit.wait_for_text("Expected gamma between")
    visit.field("gamma").scroll_into_view_if_needed()
    visit.leave()


def _library(visit: Visit) -> None:
    visit.press("Library")
    visit.page.get_by_role("dialog").wait_for()
    visit.leave()


def _help(visit: Visit) -> None:
    visit.press("Help")
    visit.page.get_by_role("dialog").wait_for()
    visit.leave()


def _run(visit: Visit, steps: int) -> None:
    visit.press("Start")
    visit.wait(lambda: visit.view.run.n_steps > steps, "the run")
    visit.press("Pause")
    visit.wait(lambda: visit.view.run.status is RunStatus.PAUSED, "the pause")


def _training(visit: Visit) -> None:
    _run(visit, 6_000)
    visit.tab("Charts")
    visit.page.locator(".js-plotly-plot").first.wait_for()
    visit.page.locator(".js-plotly-plot").first.scroll_into_view_if_needed()


def _stages(visit: Visit) -> None:
    _run(visit, 2_000)
    for stage in list(Stage)[:5]:
        visit.press("Stage")
        visit.wait(
            lambda s=stage: visit.view.walk is not None and visit.view.walk.stage is s, stage.value
        )


def _reasons(visit: Visit) -> None:
    visit.press("Decided")
    visit.wait(lambda: visit.view.selected >= 0, "the option")
    visit.page.wait_for_timeout(1_000)
    visit.choose("Open weight", "torque")


def _whole_agent(visit: Visit) -> None:
    visit.press("Decided")
    visit.page.keyboard.press("Shift+W")
    visit.wait_for_text("Counting")
    visit.wait(
        lambda: "Counting" not in visit.page.locator("body").inner_text(), "all to be counted"
    )
    shares = visit.page.locator(".ao:has(.ao-shares)")
    shares.evaluate("element => element.scrollIntoView()")


def _charts(visit: Visit) -> None:
    visit.tab("Charts")
    visit.page.locator(".js-plotly-plot").first.wait_for()


def _learners(visit: Visit) -> None:
    visit.choose("Environment", "CartPole-v0")
    visit.fill("Steps", "4000")
    visit.press("Start")
    visit.wait(lambda: visit.view.run.status is RunStatus.FINISHED, "the run")
    visit.press("Fit")
    visit.tab("Compare")
    visit.press("Draw in Charts")
    _charts(visit)
    visit.page.locator(".js-plotly-plot").first.scroll_into_view_if_needed()


def _what_if(visit: Visit) -> None:
    visit.tab("What if")
    visit.wait_for_text("HOW SURE")
    tracks = visit.page.locator(".mantine-Slider-track:visible")
    angle = tracks.nth(tracks.count() - 2)
    angle.scroll_into_view_if_needed()
    box = angle.bounding_box()
    assert box is not None
    visit.page.mouse.click(box["x"] + 0.62 * box["width"], box["y"] + box["height"] / 2)
    visit.wait(lambda: visit.view.supposed is not None, "the what-if")


def _compare(visit: Visit) -> None:
    visit.tab("Compare")
    visit.wait(lambda: any(item.label == "young" for item in visit.view.shelf), "the other agent")
    visit.choose("With", "young")
    visit.wait_for_text("STEPS WHERE THEY PART")
    visit.press("Play both")
    visit.wait_for_text("20 of 20 episodes each")
    visit.page.get_by_text("Returns from the same seeds").scroll_into_view_if_needed()


def _export(visit: Visit) -> None:
    visit.tab("Export")


SCENES: dict[str, tuple[Scene, dict[str, object]]] = {
    "dashboard": (_dashboard, {"agent": "CartPole-v1", "step": 53}),
    "first-visit": (_first_visit, {"agent": "CartPole-v1", "step": 53}),
    "moments": (_moments, {"agent": "Acrobot-v1", "step": 20}),
    "branch": (_branch, {"agent": "CartPole-v1", "step": 17}),
    "past": (_past, {"agent": "CartPole-v1", "step": 53}),
    "state-space": (_state_space, {"agent": "MountainCar-v0", "step": 90}),
    "acrobot": (_cones, {"agent": "Acrobot-v1", "step": 40}),
    "huge": (_huge, {"agent": HUGE, "step": 40}),
    "stages": (_stages, {}),
    "settings": (_settings, {"agent": "CartPole-v1", "step": 53}),
    "library": (_library, {"agent": "CartPole-v1", "step": 53}),
    "training": (_training, {}),
    "reasons": (_reasons, {"agent": "Pendulum-v1", "step": 30}),
    "whole-agent": (_whole_agent, {"agent": "CartPole-v1", "step": 53}),
    "charts": (_charts, {"agent": "Acrobot-v1", "step": 60}),
    "learners": (_learners, {}),
    "what-if": (_what_if, {"agent": "CartPole-v1", "step": 53}),
    "compare": (_compare, {"agent": "CartPole-v1", "step": 40}),
    "export": (_export, {"agent": "CartPole-v1", "step": 53}),
    "help": (_help, {"agent": "CartPole-v1", "step": 53}),
    "offline": (_dashboard, {"agent": "CartPole-v1", "step": 53}),
}
"""What is done on the page for each picture, and where the page opens."""


def take(browser: Browser, folder: Path, name: str, *themes: Theme) -> None:
    """Takes a picture in these themes, of a dashboard that nothing else was done with."""
    scene, place = SCENES[name]
    dashboard = Dashboard(port=0, folder=folder, make_runner=ThreadRunner)
    dashboard.start()
    page = browser.new_page(viewport=SIZE, color_scheme=themes[0].value, reduced_motion="reduce")
    try:
        if name != "first-visit":
            page.add_init_script(_HINT_IS_GONE)
        page.goto(f"{dashboard.address}?{urlencode(place)}")
        page.get_by_role("button", name="Start", exact=True).wait_for()
        visit = Visit(page, dashboard)
        visit.wait(lambda: bool(dashboard.views) and visit.view.appearance.is_known, "the page")
        _dismiss_notices(page)
        visit.wait(lambda: visit.view.forest is not None, "the forest")
        scene(visit)
        visit.hover_nowhere()
        for theme in themes:
            if visit.view.appearance.shown_theme is not theme:
                page.keyboard.press("Shift+C")
                visit.wait(lambda t=theme: visit.view.appearance.shown_theme is t, theme.value)
                page.wait_for_timeout(1_000)  # The picture of the other theme goes first.
            _wait_for_picture(visit, theme)
            page.wait_for_timeout(3_000)
            if name == "offline":
                dashboard.stop()
                page.locator(".ao-offline").wait_for(state="visible")
            _dismiss_notices(page)
            where = IMAGES if theme is Theme.DARK else IMAGES / "light"
            _keep(page.screenshot(), where / f"{name}.png")
    finally:
        page.close()
        dashboard.stop()


def _wait_for_picture(visit: Visit, theme: Theme) -> None:
    """Waits until the environment has been drawn where that is on its way."""
    blank = len(BLANK_JPEGS[theme])
    # A picture that has just been followed by another cannot be asked for its size any more.
    ask = """(none) => fetch(document.querySelector("img").src)
      .then((answer) => answer.blob()).then((picture) => picture.size).catch(() => none)"""
    visit.wait(lambda: visit.page.evaluate(ask, blank) != blank, "the picture")


def _dismiss_notices(page: Page) -> None:
    """Among them viser's, that the processor draws here."""
    page.wait_for_timeout(1_500)
    page.evaluate(
        "document.querySelectorAll('button.mantine-Notification-closeButton')"
        ".forEach((button) => button.click())"
    )


def _keep(png: bytes, path: Path) -> None:
    """Writes a picture small, with 256 colours that keep also what is rare, as thin lines are."""
    with Image.open(io.BytesIO(png)) as image:
        small = image.convert("RGB").quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=1)
    path.parent.mkdir(parents=True, exist_ok=True)
    small.save(path, optimize=True)
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise ValueError(
            f"Expected {path} to have at most {MOST_BYTES:,} bytes, but it has {size:,}."
        )
    print(f"{path.relative_to(IMAGES.parent)}: {size:,} bytes", flush=True)


def main() -> None:
    """Takes the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(SCENES))
    names = parser.parse_args().names or list(SCENES)
    unknown = [name for name in names if name not in SCENES]
    if unknown:
        parser.error(f"there is no picture {unknown[0]!r}, but there are {', '.join(SCENES)}")
    folder = Path("my-agents")  # As the library shows it, whoever takes the pictures.
    with (
        tempfile.TemporaryDirectory() as workplace,
        contextlib.chdir(workplace),
        sync_playwright() as playwright,
    ):
        folder.mkdir()
        if "compare" in names:
            AO2("CartPole-v1", seed=1).learn(3_000).save(folder / "young.ao2")
        if "huge" in names:
            assert make_agent_file(100_000, folder).stem == HUGE
        browser = launch(playwright)
        for name in names:
            if name == "offline":  # Without its dashboard no page changes its theme.
                take(browser, folder, name, Theme.DARK)
                take(browser, folder, name, Theme.LIGHT)
            else:
                take(browser, folder, name, *Theme)
        browser.close()


if __name__ == "__main__":
    main()
