"""What the dashboard costs with forests of ten thousand, a hundred thousand and a million options.

    .venv/bin/python -m benchmarks.scale [--sizes 10000 100000 1000000] [--folder build/scale]

Real agents (see `benchmarks.big_agents`; a million options take a quarter of an hour to learn,
once), saved to real files, shown by the real program in a process of its own to a real headless
Chromium. Bytes are counted between the two, the server's processor time by its process, what the
browser does by the page itself. For the first opening and for turning the forest the page is drawn,
in software where there is no graphics card; everything else is measured with drawing stubbed, as
else it is the drawing that is measured. While a page that comes is measured, the one that was there
before gets only what nobody else wants of the processors, as if on a machine of its own. Each size
is measured once, with a fresh server.
"""

import argparse
import contextlib
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil
from playwright.sync_api import Browser, Playwright, sync_playwright

from ao2viz.ui.detail import Detail, detail_for
from benchmarks.big_agents import make_agent_file
from benchmarks.chromium import launch, step_back
from benchmarks.machine import describe_run
from benchmarks.scale_page import Opening, Visit, visiting
from benchmarks.wire import Wire

_PLAYS_S = 10.0
_TURNS_S = 5.0
_IDLES_S = 20.0
_BROWSERS = 5
_MOVES = 20
_PATIENCE_S = 180.0
_CALM = 4  # Looks in a row, two seconds apart, at which the server must be at rest.
_AT_REST = 0.1  # Of a core: below that the server has drawn the episode and thought it over.
_FEWEST_ROOTS = 100  # Where only roots are drawn, the picture is there when there are so many.


@dataclass(frozen=True)
class Server:
    """The program with a file, and the wire to it."""

    process: psutil.Process
    wire: Wire
    started_s: float  # From the command to the address in the terminal.

    @property
    def address(self) -> str:
        """What a browser opens."""
        return f"http://127.0.0.1:{self.wire.port}"

    def cpu_s(self) -> float:
        """Processor time so far."""
        times = self.process.cpu_times()
        return times.user + times.system

    def megabytes(self) -> float:
        """Memory in use."""
        return self.process.memory_info().rss / 2**20

    def wait_for_rest(self) -> None:
        """Waits until nothing of opening is still going on."""
        deadline, calm = time.monotonic() + _PATIENCE_S, 0
        while time.monotonic() < deadline:
            before = self.cpu_s()
            time.sleep(2.0)
            calm = calm + 1 if (self.cpu_s() - before) / 2.0 < _AT_REST else 0
            if calm == _CALM:
                return
        raise RuntimeError(f"The server was not at rest after {_PATIENCE_S:.0f} s.")


@contextlib.contextmanager
def serving(path: Path) -> Iterator[Server]:
    """Starts the program on a file."""
    began = time.perf_counter()
    command = [sys.executable, "app.py", str(path), "--port", "0", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        found = re.search(r"http://[^:]+:(\d+)", process.stdout.readline())
        if found is None:
            raise RuntimeError("The program did not start.")
        started_s = time.perf_counter() - began
        wire = Wire(int(found[1]))
        try:
            yield Server(psutil.Process(process.pid), wire, started_s)
        finally:
            wire.close()
            process.terminate()


def measure(playwright: Playwright, options: int, path: Path) -> dict[str, str]:
    """Everything about one size, in words."""
    detail = detail_for(options)
    least = _FEWEST_ROOTS + 256 if detail is Detail.ROOTS else options
    told = {"file, MB": f"{path.stat().st_size / 1e6:.1f}", "drawn": detail.value}
    with launch(playwright) as browser, serving(path) as server:
        told["program started, s"] = f"{server.started_s:.1f}"
        with visiting(browser, server.address, draws=True) as visit:
            opening = visit.wait_until_drawn(least)
            told["page, s"] = f"{opening.page_s:.1f}"
            told["first picture, s"] = f"{opening.picture_s:.1f}"
            told["path lit, s"] = f"{opening.path_s:.1f}"
            told["sent until then, MB"] = f"{server.wire.received / 1e6:.2f}"
            told["browser's main thread so far, s"] = f"{visit.task_s():.1f}"
            told["server's processor so far, s"] = f"{server.cpu_s():.1f}"
            told["longest task of the browser, ms"] = f"{visit.longest_ms():.0f}"
            visit.dismiss_notices()
            visit.press("p")
            told |= _turn(visit, "drawn in software")
        told["server's memory, MB"] = f"{server.megabytes():.0f}"
        with visiting(browser, server.address, draws=False) as visit:
            told |= _tell_coming(visit.wait_until_drawn(least), "nobody else is there")
            visit.dismiss_notices()
            told |= _play(server, [visit], "one browser")
        with launch(playwright) as elsewhere, watching(elsewhere, server, least) as other:
            step_back(elsewhere)
            step = other.step()
            told |= _join(browser, server, least, "another plays")
            if other.step() <= step:
                raise RuntimeError("The other did not play any more.")
        with watching(browser, server, least) as visit:
            with contextlib.ExitStack() as stack:
                others = [
                    stack.enter_context(watching(browser, server, least))
                    for _ in range(_BROWSERS - 1)
                ]
                told |= _play(server, [visit, *others], f"{_BROWSERS} browsers")
            visit.press("p")
            told |= _turn(visit, "drawing stubbed")
            server.wait_for_rest()
            told |= _idle(server, visit)
            told |= _scrub(server, visit)
        if detail is not Detail.ROOTS:
            with launch(playwright) as elsewhere, watching(elsewhere, server, least) as other:
                other.train_on()
                step_back(elsewhere)
                told |= _join(browser, server, least, "it learns on")
        told["server's memory at the end, MB"] = f"{server.megabytes():.0f}"
    return told


@contextlib.contextmanager
def watching(browser: Browser, server: Server, least: int) -> Iterator[Visit]:
    """A page that has drawn all, and plays."""
    with visiting(browser, server.address, draws=False) as visit:
        visit.wait_until_drawn(least)
        visit.dismiss_notices()
        yield visit


def _turn(visit: Visit, how: str) -> dict[str, str]:
    visit.page.wait_for_timeout(2000)
    before, work = visit.frames(), visit.task_s()
    visit.orbit(_TURNS_S)
    frames = max(1, visit.frames() - before)
    return {
        f"turning, {how}: frames a second": f"{frames / _TURNS_S:.1f}",
        f"turning, {how}: browser, ms a frame": f"{1e3 * (visit.task_s() - work) / frames:.1f}",
    }


def _play(server: Server, visits: list[Visit], how: str) -> dict[str, str]:
    """Lets episodes play from their beginning."""
    for visit in visits:
        visit.press("q")
        visit.press("p")
    visits[0].page.wait_for_timeout(2000)
    steps, began = [visit.step() for visit in visits], time.monotonic()
    sent, work, browser = server.wire.received, server.cpu_s(), visits[0].task_s()
    visits[0].longest_ms()
    visits[0].page.wait_for_timeout(1000 * _PLAYS_S)
    taken = [visit.step() - step for visit, step in zip(visits, steps, strict=True)]
    seconds, total = time.monotonic() - began, max(1, sum(taken))
    kilobytes = (server.wire.received - sent) / total / 1e3
    browser_ms = 1e3 * (visits[0].task_s() - browser) / max(1, taken[0])
    what = f"playing, {how}"
    return {
        f"{what}: steps a second": ", ".join(f"{n / seconds:.1f}" for n in taken),
        f"{what}: KB a step and browser": f"{kilobytes:.1f}",
        f"{what}: server, % of a core": f"{100 * (server.cpu_s() - work) / seconds:.0f}",
        f"{what}: browser, ms a step": f"{browser_ms:.1f}",
        f"{what}: longest task of the browser, ms": f"{visits[0].longest_ms():.0f}",
    }


def _join(browser: Browser, server: Server, least: int, how: str) -> dict[str, str]:
    """Somebody comes while another watches."""
    before = server.cpu_s()
    with visiting(browser, server.address, draws=False) as visit:
        return {
            **_tell_coming(visit.wait_until_drawn(least), how),
            f"who comes while {how}: browser's main thread, s": f"{visit.task_s():.1f}",
            f"who comes while {how}: server's processor, s": f"{server.cpu_s() - before:.1f}",
        }


def _scrub(server: Server, visit: Visit) -> dict[str, str]:
    """Looks at random moments of training; the first arranges every option that ever was."""
    visit.open_tab("Past")
    life = visit.greatest("After step")
    first = visit.look_back(life - 1)
    server.wait_for_rest()
    moments = np.random.default_rng(1).integers(life // 50, life, _MOVES).tolist()
    sent, work, browser = server.wire.received, server.cpu_s(), visit.task_s()
    moves = [1e3 * visit.look_back(moment) for moment in moments]
    return {
        "past: first look, s": f"{first:.1f}",
        "past: a move, median ms until drawn": f"{statistics.median(moves):.0f}",
        "past: a move, longest": f"{max(moves):.0f}",
        "past: a move, KB": f"{(server.wire.received - sent) / _MOVES / 1e3:.0f}",
        "past: a move, server ms": f"{1e3 * (server.cpu_s() - work) / _MOVES:.0f}",
        "past: a move, browser ms": f"{1e3 * (visit.task_s() - browser) / _MOVES:.0f}",
    }


def _tell_coming(opening: Opening, how: str) -> dict[str, str]:
    who = f"who comes while {how}"
    return {
        f"{who}: page, s": f"{opening.page_s:.1f}",
        f"{who}: path lit, s": f"{opening.path_s:.1f}",
        f"{who}: first picture, s": f"{opening.picture_s:.1f}",
    }


def _idle(server: Server, visit: Visit) -> dict[str, str]:
    sent, work, browser = server.wire.received, server.cpu_s(), visit.task_s()
    visit.page.wait_for_timeout(1000 * _IDLES_S)
    return {
        "idle: server, % of a core": f"{100 * (server.cpu_s() - work) / _IDLES_S:.1f}",
        "idle: browser, % of a core": f"{100 * (visit.task_s() - browser) / _IDLES_S:.1f}",
        "idle: sent, bytes a second": f"{(server.wire.received - sent) / _IDLES_S:.0f}",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--folder", type=Path, default=Path("build/scale"))
    arguments = parser.parse_args()
    files = [make_agent_file(options, arguments.folder) for options in arguments.sizes]
    with sync_playwright() as playwright:
        columns = []
        for options, path in zip(arguments.sizes, files, strict=True):
            columns.append(measure(playwright, options, path))
            print(f"{options:,}: {columns[-1]}", file=sys.stderr, flush=True)
    print(describe_run("benchmarks.scale"))
    print("Acrobot-v1, seed 0, each size once.\n")
    print("| | " + " | ".join(f"{options:,} options" for options in arguments.sizes) + " |")
    print("|---|" + "---:|" * len(columns))
    for row in columns[0]:
        print(f"| {row} | " + " | ".join(column[row] for column in columns) + " |")


if __name__ == "__main__":
    main()
