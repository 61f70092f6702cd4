"""A headless Chromium that draws in software, or not at all, and a count of what it draws."""

import contextlib
import os
import shutil
import sys
from pathlib import Path

import psutil
from playwright.sync_api import Browser, Playwright

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# WebGL is drawn in software, and only WebGL: to put the rest of a page together by an emulated
# graphics card would take ten times what it takes without one.
_FLAGS = [
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
                      "drawElementsInstanced"])
    if (context.prototype[name]) context.prototype[name] = () => {};
"""
"""Run before a page's own scripts: the calls that draw do nothing."""

_LAST = 19  # Niceness.


def launch(playwright: Playwright) -> Browser:
    """Starts the Chromium or Chrome of this machine; without one there is nothing to measure."""
    program = next(filter(None, map(shutil.which, _NAMES)), None)
    if program is None:
        sys.exit("No Chromium or Chrome found.")
    flags = [*_FLAGS, *(["--no-sandbox"] if os.name == "posix" and os.getuid() == 0 else [])]
    return playwright.chromium.launch(executable_path=program, args=flags)


def step_back(browser: Browser) -> None:
    """Lets a browser have only what nobody else wants of the processors, from now to its end."""
    told = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")
    for one in told["processInfo"]:
        with contextlib.suppress(psutil.NoSuchProcess, OSError):
            psutil.Process(one["id"]).nice(_LAST)
            # Where Linux shares the processors between sessions first, all of its own come last.
            Path(f"/proc/{one['id']}/autogroup").write_text(str(_LAST))
