"""A person's browser, as a process: opens a page, says "ready", stays until its stdin closes.

    python -m benchmarks.visitor http://127.0.0.1:8080 [--draw]

Without --draw the WebGL draw calls do nothing: a machine without a graphics card would draw in
software and take the processor away from training, which no design of ours could change.
"""

import argparse
import sys

from playwright.sync_api import sync_playwright

from benchmarks.chromium import NO_DRAWING, launch


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("address")
    parser.add_argument("--draw", action="store_true")
    arguments = parser.parse_args()
    with sync_playwright() as playwright:
        browser = launch(playwright)
        page = browser.new_page(viewport={"width": 1440, "height": 810})
        if not arguments.draw:
            page.add_init_script(NO_DRAWING)
        page.goto(arguments.address)
        page.wait_for_selector("canvas")
        print("ready", flush=True)
        sys.stdin.read()
        browser.close()


if __name__ == "__main__":
    main()
