"""The keys and commands of one browser, as its panels make them; no page is opened."""

from collections import Counter
from collections.abc import Iterator
from types import SimpleNamespace

import pytest

from ao2viz.ui.browser import Browser
from ao2viz.ui.inbox import Inbox, Key
from ao2viz.ui.security import make_server
from ao2viz.ui.stage import Stage

CLIENT = 7


@pytest.fixture(scope="module")
def keys() -> Iterator[tuple[Key, ...]]:
    server, inbox = make_server("127.0.0.1", 0), Inbox()
    # Panels need of a client only what the server has too.
    client = SimpleNamespace(
        client_id=CLIENT, gui=server.gui, scene=server.scene, atomic=server.atomic, camera=None
    )
    Browser(client, Stage(server), inbox)  # pyright: ignore[reportArgumentType]
    yield inbox.keys_of(CLIENT)
    server.stop()


def test_no_two_commands_have_the_same_key(keys):
    pressed = Counter((key.hotkey.lower(), key.modifier) for key in keys if key.hotkey)
    assert len(pressed) > 40
    assert [key for key, times in pressed.items() if times > 1] == []


def test_no_two_commands_have_the_same_name(keys):
    assert [name for name, times in Counter(key.label for key in keys).items() if times > 1] == []
