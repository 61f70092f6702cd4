"""A headless Chromium that draws in software, or not at all, and a count of what it draws."""

import contextlib
import os
import shutil
import sys
from pathlib import Path

from playwright.sync_api import Browser, Playwright

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# WebGL is drawn in software, and only WebGL: to put the rest of a page together by an emulated
# graphics card would take ten times what it takes without one.
_FLAGS = [
    "--no-sandbox",  # Which root may not use; all pages are our own.
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
NO_DRAWING = """
for (const context of [WebGLRenderingContext, WebGL2RenderingContext])
  for (const name of ["clear", "drawArrays", "drawElements", "drawArraysInstanced",
                      "drawElementsInstanced", "drawRangeElements"])
    if (context.prototype[name]) context.prototype[name] = () => {};
"""
"""Run before a page's own scripts: the calls that draw do nothing."""
NO_WARNING = """
for (const context of [WebGLRenderingContext, WebGL2RenderingContext]) {
  const get = context.prototype.getExtension;
  context.prototype.getExtension = function (name) {
    return name === "WEBGL_debug_renderer_info" ? null : get.call(this, name);
  };
}
"""
"""Run before a page's own scripts: viser cannot know, and warn, that the processor draws."""

_LAST = 19  # Niceness.


def find() -> str | None:
    """The Chromium or Chrome of this machine."""
    return next(filter(None, map(shutil.which, _NAMES)), None)


def launch(playwright: Playwright) -> Browser:
    """Starts the Chromium or Chrome of this machine; without one there is nothing to look with."""
    program = find()
    if program is None:
        sys.exit("No Chromium or Chrome found.")
    return playwright.chromium.launch(executable_path=program, args=_FLAGS)


def step_back(browser: Browser) -> None:
    """Lets a browser have only what nobody else wants of the processors, from now to its end."""
    told = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")
    for one in told["processInfo"]:
        with contextlib.suppress(OSError):  # It has gone.
            os.setpriority(os.PRIO_PROCESS, one["id"], _LAST)
            # Where Linux shares the processors between sessions first, all of its own come last.
            Path(f"/proc/{one['id']}/autogroup").write_text(str(_LAST))
