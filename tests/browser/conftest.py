"""A real Chromium on a real dashboard. A missing browser skips; where CI is set it fails."""

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page, sync_playwright

from ao2viz.agent import AO2
from ao2viz.training.runner import ThreadRunner
from ao2viz.ui.app import Dashboard
from ao2viz.ui.appearance import KEY
from ao2viz.ui.view import View
from benchmarks.chromium import NO_DRAWING, NO_WARNING, find, launch

SIZE = {"width": 1440, "height": 810}
PATIENCE_S = 30.0
HINT_KEY = f"viser-user:{KEY}"  # Viser puts its prefix before what servers store.


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.browser)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item):
    report = yield
    setattr(item, f"report_{report.when}", report)
    return report


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """One for each module: Playwright keeps an event loop that would disturb other tests."""
    if find() is None:
        problem = "No Chromium on this computer."
        if os.environ.get("CI"):
            pytest.fail(problem)
        pytest.skip(problem)
    with sync_playwright() as playwright:
        browser = launch(playwright)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of two small agents with recorded episodes."""
    folder = tmp_path_factory.mktemp("agents")
    for env_id, steps in (("CartPole-v1", 1500), ("Pendulum-v1", 500)):
        agent = AO2(env_id, seed=0).learn(steps)
        agent.record_episode(1)
        agent.record_episode(2)
        agent.save(folder / f"{env_id}.ao2")
    return folder


class Window:
    """A page on a dashboard, and what the dashboard thinks that it shows."""

    def __init__(self, page: Page, dashboard: Dashboard, client_id: int) -> None:
        self.page, self.dashboard, self._client_id = page, dashboard, client_id

    @property
    def view(self) -> View:
        return self.dashboard.views[self._client_id]

    def press(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).click()

    def choose(self, label: str, option: str) -> None:
        """Picks an option of the drop-down list with this label."""
        self.field(label).click()
        self.page.get_by_role("option", name=option).first.click()

    def field(self, label: str):
        # By its label: viser gives some of its inputs no id.
        named = self.page.locator("label", has_text=label).first
        return named.locator("xpath=ancestor::div[.//input][1]").locator("input:visible").first

    def wait(
        self, condition: Callable[[], bool], what: str, patience_s: float = PATIENCE_S
    ) -> None:
        deadline = time.monotonic() + patience_s
        while not condition():
            assert time.monotonic() < deadline, f"Waited in vain for {what}."
            self.page.wait_for_timeout(50)

    def wait_for_none(self, find: Callable[[], list], what: str = "") -> None:
        """Waits until nothing is found, as what has just been drawn may take a moment to settle."""
        deadline = time.monotonic() + PATIENCE_S / 3
        while (found := find()) and time.monotonic() < deadline:
            self.page.wait_for_timeout(200)
        assert found == [], what

    def text(self) -> str:
        return self.page.locator("body").inner_text()

    def wait_for_text(self, words: str, patience_s: float = PATIENCE_S) -> None:
        self.wait(lambda: words in self.text(), repr(words), patience_s)

    def hold(self) -> None:
        """Stops a playing episode at a decision and waits until the page has caught up."""
        button = self.page.get_by_role("button", name="Hold", exact=True)
        self.wait(lambda: not self.view.transport.is_playing or button.count() > 0, "a button")
        # Playwright's own click wants the button to stand still for two frames, and a page that
        # the processor draws while it plays may take long for two frames.
        button.evaluate_all("all => all.forEach((button) => button.click())")
        self.wait(lambda: not self.view.transport.is_playing, "the replay to hold")
        if self.view.decision is None and self.view.transport.last:
            self.press("First step")  # A slow machine has played it to its end meanwhile.
            self.wait(lambda: self.view.decision is not None, "the first decision")
        self.wait_for_text(self.view.notice or f"{self.view.decision.path[-1]}")


Open = Callable[..., Window]


@pytest.fixture
def open_window(browser: Browser, request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Open]:
    """Opens pages on a dashboard; a console error fails the test, a failure keeps a screenshot."""
    pages: list[Page] = []
    contexts: list[BrowserContext] = []
    errors: list[str] = []

    def listen(message: ConsoleMessage) -> None:
        if message.type == "error":
            errors.append(message.text)

    def open_one(
        dashboard: Dashboard,
        *,
        draws: bool = False,
        size=SIZE,
        query: str = "",
        is_first_visit: bool = False,
        context: BrowserContext | None = None,
    ) -> Window:
        known = set(dashboard.views)
        context = context or browser.new_context(color_scheme="dark")
        contexts.append(context)
        page = context.new_page()
        page.set_viewport_size(size)
        if not is_first_visit:
            page.add_init_script(
                f"localStorage.getItem('{HINT_KEY}') ||"
                f"localStorage.setItem('{HINT_KEY}', '{{\"hint_is_gone\": true}}')"
            )
        pages.append(page)
        page.on("console", listen)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.add_init_script(NO_WARNING)
        if not draws:
            page.add_init_script(NO_DRAWING)
        page.goto(dashboard.address + (f"?{query}" if query else ""))
        page.wait_for_selector("canvas")
        window = Window(page, dashboard, -1)
        window.wait(lambda: set(dashboard.views) > known, "the browser to be known")
        window._client_id = (set(dashboard.views) - known).pop()
        page.get_by_role("button", name="Start", exact=True).wait_for()
        return window

    yield open_one
    failed = getattr(request.node, "report_call", None)
    if failed is not None and failed.failed:
        for number, page in enumerate(pages):
            page.screenshot(path=tmp_path / f"failure-{number}.png")
    for context in contexts:
        context.close()
    assert errors == []


@pytest.fixture
def dashboard(shipped: Path, tmp_path: Path) -> Iterator[Dashboard]:
    """A dashboard that trains in a thread, so that nothing is compiled twice."""
    made = Dashboard(port=0, shipped=shipped, folder=tmp_path, make_runner=ThreadRunner)
    made.start()
    yield made
    made.stop()
