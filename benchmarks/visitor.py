"""A person's browser, as a process: opens a page, says "ready", stays until its stdin closes.

    python -m benchmarks.visitor http://127.0.0.1:8080 [--draw]

Without --draw the WebGL draw calls do nothing: a machine without a graphics card would draw in
software and take the processor away from training, which no design of ours could change.
"""

import argparse
import os
import shutil
import sys

from playwright.sync_api import sync_playwright

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_FLAGS = [
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
_NO_DRAWING = """
for (const context of [WebGLRenderingContext, WebGL2RenderingContext])
  for (const name of ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"])
    if (context.prototype[name]) context.prototype[name] = () => {};
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("address")
    parser.add_argument("--draw", action="store_true")
    arguments = parser.parse_args()
    program = next(filter(None, map(shutil.which, _NAMES)), None)
    if program is None:
        sys.exit("No Chromium or Chrome found.")
    flags = [*_FLAGS, *(["--no-sandbox"] if os.name == "posix" and os.getuid() == 0 else [])]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=flags)
        page = browser.new_page(viewport={"width": 1440, "height": 810})
        if not arguments.draw:
            page.add_init_script(_NO_DRAWING)
        page.goto(arguments.address)
        page.wait_for_selector("canvas")
        print("ready", flush=True)
        sys.stdin.read()
        browser.close()


if __name__ == "__main__":
    main()
