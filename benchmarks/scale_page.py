"""One page on a dashboard, seen from the browser: when what was drawn, and what it cost there."""

import contextlib
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass

from playwright.sync_api import Browser, Locator, Page

from benchmarks.chromium import NO_DRAWING

_SETTLES_S = 4.0
"""A page that has drawn the same for so long draws all that there is to draw."""
_LASTS_S = 2.5
"""A forest to which nothing came for so long is there as a whole: at rest a page draws each 1 s."""
_PATIENCE_S = 180.0
_MARKS = 32
"""Instances of the nodes that hold the marks of the path; no other node has as many."""
_BULK = 10_000
"""Bytes of a frame beside the one before: a chunk of the forest changes more, the path less."""
_MANY = 500
"""Shapes more or fewer than in the frame before: a part of the forest has come or gone."""
# Of every frame: when it was, how many shapes it drew, and whether the path's marks were in it.
# Frames that draw as many as the one before are only counted. `bytes`: what the last frame handed
# to the graphics card, in which order to draw alone takes some; `bulk`: when a frame last handed
# over much more than the one before, or drew many shapes more or fewer: a part of the forest came
# or went; `typed`: when a field was last typed into.
_COUNTING = (
    """
(() => {
  const seen = window.seen = {
    frames: 0, changes: [], longest: 0, long: 0, bytes: 0, bulk: 0, typed: 0,
  };
  let shapes = 0, last = 0, marks = 0, before = "", bytes = 0, handed = 0;
  const now = () => (performance.timeOrigin + performance.now()) / 1000;
  addEventListener("input", () => { seen.typed = now(); }, true);
  for (const name of ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"])
    for (const kind of [WebGLRenderingContext, WebGL2RenderingContext]) {
      const draw = kind.prototype[name];
      if (!draw) continue;
      kind.prototype[name] = function (...given) {
        const dots = given[0] === 0 ? given[name === "drawArrays" ? 2 : 1] : 0;
        const n = name.endsWith("Instanced") ? given[given.length - 1] : dots;
        shapes += n;
        if (n === MARKS) marks += 1;
        handed = now();
        return draw.apply(this, given);
      };
    }
  for (const name of ["bufferData", "bufferSubData", "texImage2D", "texSubImage2D"])
    for (const kind of [WebGLRenderingContext, WebGL2RenderingContext]) {
      const send = kind.prototype[name];
      kind.prototype[name] = function (...given) {
        for (const one of given) bytes += one?.byteLength ?? 0;
        handed = now();
        return send.apply(this, given);
      };
    }
  const look = () => {
    if (bytes > seen.bytes + BULK) seen.bulk = handed;
    if (bytes) seen.bytes = bytes;
    bytes = 0;
    if (shapes) {
      seen.frames += 1;
      if (Math.abs(shapes - last) > MANY) seen.bulk = handed;
      last = shapes;
      const drawn = `${shapes} ${marks > 0}`;
      if (drawn !== before) seen.changes.push([now(), shapes, marks]);
      before = drawn;
      shapes = marks = 0;
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
  new PerformanceObserver(list => list.getEntries().forEach(entry => {
    seen.long += 1;
    seen.longest = Math.max(seen.longest, entry.duration);
  })).observe({entryTypes: ["longtask"]});
})();
""".replace("MARKS", str(_MARKS))
    .replace("BULK", str(_BULK))
    .replace("MANY", str(_MANY))
)


@dataclass(frozen=True)
class Opening:
    """What a person waits for, in seconds from typing the address."""

    page_s: float  # The page is there: its buttons can be pressed.
    picture_s: float  # As many shapes are drawn as in the end.
    path_s: float  # The path is lit.
    shapes: int  # Drawn in one frame.


class Visit:
    """A page that is open. Times are of the browser's main thread."""

    def __init__(self, page: Page, began: float) -> None:
        """`began`: when its address was typed, seconds since the epoch."""
        self.page = page
        self._began = began
        self._session = page.context.new_cdp_session(page)
        self._session.send("Performance.enable")

    def wait_until_drawn(self, least: int) -> Opening:
        """Waits until so many shapes are drawn, and nothing new any more."""
        self.page.get_by_role("button", name="Start", exact=True).wait_for(
            timeout=1000 * _PATIENCE_S
        )
        page_s = time.time() - self._began
        deadline = time.monotonic() + _PATIENCE_S
        while True:
            changes = self.page.evaluate("window.seen.changes")
            # While a path plays its lines come and go; what counts is the bulk of the picture.
            most = max((shapes for _, shapes, _ in changes), default=0)
            full = [at for at, shapes, _ in changes if shapes >= 0.9 * most]
            lit = [at for at, _, marks in changes if marks]
            if most >= least and lit and time.time() - max(full[0], lit[0]) > _SETTLES_S:
                return Opening(page_s, full[0] - self._began, lit[0] - self._began, most)
            if time.monotonic() > deadline:
                raise RuntimeError(f"Nothing was drawn for {_PATIENCE_S:.0f} s.")
            self.page.wait_for_timeout(200)

    def task_s(self) -> float:
        """What the main thread has worked so far."""
        metrics = self._session.send("Performance.getMetrics")["metrics"]
        return next(metric["value"] for metric in metrics if metric["name"] == "TaskDuration")

    def frames(self) -> int:
        """Frames drawn so far."""
        return self.page.evaluate("window.seen.frames")

    def longest_ms(self) -> float:
        """The longest time that the page did not answer, since the last call."""
        return self.page.evaluate(
            "(() => {const was = seen.longest; seen.longest = 0; return was})()"
        )

    def step(self) -> int:
        """The step of the replay that the page shows."""
        return int(self._number("Step").input_value())

    def look_back(self, step: int) -> float:
        """Types a moment of training; seconds until the forest of then is all on the canvas."""
        self._number("After step").fill(str(step))
        deadline = time.monotonic() + _PATIENCE_S
        while time.monotonic() < deadline:
            self.page.wait_for_timeout(100)
            bulk, typed = self.page.evaluate("[seen.bulk, seen.typed]")
            if bulk > typed and time.time() - bulk > _LASTS_S:
                return bulk - typed
        raise RuntimeError(f"The forest did not change for {_PATIENCE_S:.0f} s.")

    def open_tab(self, name: str) -> None:
        """Brings what is behind a tab to the front."""
        self.page.get_by_role("tab", name=name, exact=True).click()

    def greatest(self, label: str) -> int:
        """The end of a slider."""
        slider = self._field(label).get_by_role("slider").first
        return int(slider.get_attribute("aria-valuemax") or 0)

    def _number(self, label: str) -> Locator:
        return self._field(label).locator("input:visible").first

    def _field(self, label: str) -> Locator:
        named = self.page.locator("label", has_text=re.compile(f"^{label}$")).first
        return named.locator("xpath=ancestor::div[.//input][1]")

    def press(self, key: str) -> None:
        """As a person presses it."""
        self.page.keyboard.press(key)

    def train_on(self) -> None:
        """Lets the agent learn on, and waits until it does."""
        # By button: while a field has the focus keys are typed into it.
        self.page.get_by_role("button", name="Train on", exact=True).click()
        pause = self.page.get_by_role("button", name="Pause", exact=True)
        pause.and_(self.page.locator(":enabled")).wait_for(timeout=1000 * _PATIENCE_S)

    def dismiss_notices(self) -> None:
        """Closes what pops up, as viser does about drawing in software."""
        self.page.evaluate(
            "document.querySelectorAll('button.mantine-Notification-closeButton')"
            ".forEach(button => button.click())"
        )

    def orbit(self, seconds: float) -> None:
        """Drags around the middle of the canvas."""
        mouse, (x, y) = self.page.mouse, (690.0, 400.0)
        mouse.move(x, y)
        mouse.down()
        began, moves = time.monotonic(), 0
        while time.monotonic() - began < seconds:
            moves += 1
            mouse.move(x + 120 * ((moves % 60) / 30 - 1), y + 40 * ((moves % 40) / 20 - 1))
        mouse.up()


@contextlib.contextmanager
def visiting(browser: Browser, address: str, *, draws: bool) -> Iterator[Visit]:
    """A new browser window of a new person, on this address."""
    context = browser.new_context(viewport={"width": 1440, "height": 810})
    page = context.new_page()
    if not draws:
        page.add_init_script(NO_DRAWING)
    page.add_init_script(_COUNTING)
    began = time.time()
    page.goto(address, timeout=1000 * _PATIENCE_S)
    try:
        yield Visit(page, began)
    finally:
        context.close()
