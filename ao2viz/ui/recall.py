"""Asks a browser what it remembers, off the app loop: the answer takes a round trip."""

import contextlib
import threading

import viser
from viser._messages import RunJavascriptMessage

from ao2viz.ui.appearance import KEY, Recall, from_text
from ao2viz.ui.inbox import Inbox

_ANSWER_KEY = "ao2viz-answer"
# Viser lets a server read only what is stored under a prefix of its own, so what the system
# prefers is stored there first.
_PREFIX = "viser-user:"
_ASK = f"""try {{ localStorage.setItem("{_PREFIX}{_ANSWER_KEY}", JSON.stringify({{
  light: matchMedia("(prefers-color-scheme: light)").matches,
  still: matchMedia("(prefers-reduced-motion: reduce)").matches,
  chosen: localStorage.getItem("{_PREFIX}{KEY}"),
}})); }} catch {{}}"""


def recall(client: viser.ClientHandle, inbox: Inbox) -> None:
    """Sends what the browser remembers as a command, some time later."""
    threading.Thread(target=_ask, args=(client, inbox), name="recall", daemon=True).start()


def _ask(client: viser.ClientHandle, inbox: Inbox) -> None:
    # A browser that has gone says nothing, and one that lets nobody store anything is as on its
    # first visit each time, but for the hint, which it could never dismiss for good.
    with contextlib.suppress(RuntimeError):
        client._websock_connection.queue_message(RunJavascriptMessage(source=_ASK))
        inbox.put(client.client_id, Recall(from_text(client.local_storage.get_item(_ANSWER_KEY))))


def remember(client: viser.ClientHandle, text: str) -> None:
    """Lets the browser keep this for its next visit."""
    client.local_storage.set_item(KEY, text)
