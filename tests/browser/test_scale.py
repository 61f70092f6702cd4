"""What the page costs while nobody does anything with it, and what it shows of huge forests."""

import numpy as np
import pytest

from ao2viz.core.decision import NO_OPTION
from ao2viz.ui import detail
from ao2viz.ui.app import Dashboard
from ao2viz.ui.browser import Browser
from tests.browser.conftest import Open


def pushed(dashboard: Dashboard) -> int:
    """Messages that went to any browser so far."""
    assert dashboard._server is not None
    clients = dashboard._server.get_clients().values()
    buffers = [client._websock_connection.get_message_buffer() for client in clients]
    buffers.append(dashboard._server._websock_server.get_message_buffer())
    return sum(buffer.message_counter for buffer in buffers)


def test_a_page_that_nobody_touches_gets_no_messages(
    dashboard: Dashboard, open_window: Open, monkeypatch
):
    window = open_window(dashboard)
    window.hold()
    looks = []
    sync = Browser.sync
    monkeypatch.setattr(Browser, "sync", lambda *args: looks.append(1) or sync(*args))

    def is_at_rest() -> bool:
        # Until then the pictures of the episode are drawn, and what follows is thought about.
        before, seen = pushed(dashboard), len(looks)
        window.page.wait_for_timeout(4000)
        return pushed(dashboard) == before and len(looks) - seen <= 6

    window.wait(is_at_rest, "four seconds without a message and with little to do")
    before = pushed(dashboard)
    window.page.keyboard.press("d")
    window.wait(lambda: pushed(dashboard) > before, "a step to be sent")


@pytest.fixture
def small_page(monkeypatch) -> None:
    """A page that can show a hundred shapes and two hundred dots."""
    monkeypatch.setattr(detail, "MOST_SHAPES", 100)
    monkeypatch.setattr(detail, "MOST_DOTS", 200)


def test_of_a_huge_forest_the_page_shows_roots_and_the_active_schemas_and_says_so(
    dashboard: Dashboard, open_window: Open, small_page
):
    window = open_window(dashboard)
    window.wait_for_text("too many to draw: roots only")
    window.wait_for_text("in full: the active schemas")
    window.hold()
    shown = dashboard._browsers[window._client_id]
    picture = shown._picture
    assert picture is not None
    forest = window.view.forest
    roots = np.flatnonzero((forest.parents == NO_OPTION) & forest.is_alive)
    assert picture.drawn.tolist() == roots.tolist()
    root, decided = (int(window.view.decision.path[i]) for i in (0, -1))

    def close_up() -> tuple[int, ...]:
        return shown._close_up.roots if shown._close_up is not None else ()

    window.wait(lambda: close_up() == (root,), "the schema of the path")
    assert decided in shown._close_up.options
    other = int(next(i for i in roots if i != root))
    window.page.get_by_role("tab", name="Inspect").click()
    window.field("Option id").fill(str(other))
    window.page.keyboard.press("Enter")
    window.wait(lambda: set(close_up()) == {root, other}, "the schema of the selection")


def test_who_comes_while_others_watch_gets_the_same_picture(
    dashboard: Dashboard, open_window: Open, small_page
):
    first = open_window(dashboard)
    first.hold()
    second = open_window(dashboard)
    second.hold()
    both = [dashboard._browsers[window._client_id] for window in (first, second)]
    first.wait(lambda: all(b._picture is not None for b in both), "the pictures")
    first.wait(lambda: not any(b._canvas.is_busy for b in both), "both to be sent everything")
    assert both[0]._picture is both[1]._picture
    kinds = [b._canvas._chunks._chunks for b in both]
    nodes = [
        [chunk._nodes for chunks in kind.values() for chunk in chunks.values()] for kind in kinds
    ]
    assert len(nodes[0]) == len(nodes[1]) > 0
    for one, other in zip(*nodes, strict=True):
        np.testing.assert_array_equal(one.batched_positions, other.batched_positions)
        np.testing.assert_array_equal(one.batched_colors, other.batched_colors)
