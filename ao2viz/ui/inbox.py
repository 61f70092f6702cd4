"""Where clicks wait for the app loop, and the only callbacks that viser ever gets from us."""

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import viser

from ao2viz.ui.commands import Command, Pick
from ao2viz.ui.security import set_value


@dataclass(frozen=True)
class Connect:
    """A browser came."""

    query: str = ""  # What its address asks for; from anybody, so to be checked.


@dataclass(frozen=True)
class Disconnect:
    """A browser went."""


class Key(NamedTuple):
    """What the palette offers, and the key for it."""

    label: str
    hotkey: str | None
    modifier: str | None

    @property
    def shown(self) -> str:
        """The key as people read it; empty if there is none."""
        if self.hotkey is None:
            return ""
        if self.hotkey == "?":  # Shift is how most keyboards type it; the sign says enough.
            return "?"
        name = self.hotkey if len(self.hotkey) == 1 else self.hotkey.capitalize()
        return f"{self.modifier.capitalize()}+{name}" if self.modifier else name


Envelope = tuple[int, Command | Connect | Disconnect]
"""Which browser, and what it asks."""


class Inbox:
    """Commands of all browsers in the order they came; any thread puts, the app loop drains."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[Envelope] = queue.SimpleQueue()
        self._has_news = threading.Event()
        self._keys: dict[int, list[viser.CommandHandle]] = {}

    def put(self, client_id: int, command: Command | Connect | Disconnect) -> None:
        """Leaves a command for the app loop."""
        self._queue.put((client_id, command))
        self._has_news.set()

    def wait(self, seconds: float) -> None:
        """Waits so long, or until a command comes; not at all if one came since the last wait."""
        self._has_news.wait(seconds)
        self._has_news.clear()

    def note_key(self, client_id: int, handle: viser.CommandHandle) -> None:
        """Remembers what can be asked by key or from the palette."""
        self._keys.setdefault(client_id, []).append(handle)

    def drop_key(self, client_id: int, handle: viser.CommandHandle) -> None:
        """Forgets what has been taken out of the palette."""
        self._keys[client_id].remove(handle)

    def keys_of(self, client_id: int) -> tuple[Key, ...]:
        """Everything in the palette of a browser, in the order it was made."""
        return tuple(
            Key(handle.label, handle.hotkey, handle.modifier)
            for handle in self._keys.get(client_id, [])
        )

    def forget(self, client_id: int) -> None:
        """A browser went."""
        self._keys.pop(client_id, None)

    def drain(self) -> list[Envelope]:
        """Takes everything that is waiting."""
        taken = []
        while True:
            try:
                taken.append(self._queue.get_nowait())
            except queue.Empty:
                return taken


# The callbacks are `async` although they await nothing: viser runs those in order of arrival,
# plain ones on a pool where a slow one reads a value that has changed since.


def on_click(handle: viser.GuiButtonHandle, command: Command, client_id: int, inbox: Inbox) -> None:
    """Sends a command whenever the button is pressed."""

    @handle.on_click
    async def _(_: viser.GuiEvent) -> None:
        inbox.put(client_id, command)


def on_press(
    handle: viser.GuiButtonHandle | viser.CommandHandle,
    get_command: Callable[[], Command | None],
    client_id: int,
    inbox: Inbox,
) -> None:
    """Sends what a button or a key stands for at the moment it is pressed; None sends nothing."""

    async def press(_: object) -> None:
        command = get_command()
        if command is not None:
            inbox.put(client_id, command)

    if isinstance(handle, viser.CommandHandle):
        inbox.note_key(client_id, handle)
        handle.on_trigger(press)
    else:
        handle.on_click(press)


def on_change(
    handle: Any, to_command: Callable[[Any], Command | None], client_id: int, inbox: Inbox
) -> None:
    """Sends a command whenever a person changes the value; None sends nothing."""

    @handle.on_update
    async def _(event: viser.GuiEvent) -> None:
        if event.client is None:  # Assigned by `sync`, not by a person.
            return
        # As the control holds it, which has whole numbers for some that a browser sends.
        command = to_command(type(event.target.value)(set_value()))
        if command is not None:
            inbox.put(client_id, command)


def on_trigger(handle: viser.CommandHandle, command: Command, client_id: int, inbox: Inbox) -> None:
    """Sends a command when its key is pressed or it is chosen in the palette."""
    inbox.note_key(client_id, handle)

    @handle.on_trigger
    async def _(_: viser.CommandEvent) -> None:
        inbox.put(client_id, command)


def on_canvas_click(scene: viser.SceneApi, client_id: int, inbox: Inbox) -> None:
    """Sends the ray of every click on the canvas."""

    async def put(event: viser.SceneClickEvent) -> None:
        inbox.put(client_id, Pick(event.ray_origin, event.ray_direction))

    # Viser's annotation leaves out that it awaits coroutines here as everywhere.
    scene.on_click()(put)  # pyright: ignore[reportArgumentType]
