"""Who may talk to the dashboard, and what they may say.

Viser trusts whoever connects. Here that trust is taken back at the two places that everything
passes: the handshake of each connection, and the door for incoming messages. Both are private to
viser, so `tests/ui/test_security.py` tells loudly if a new version moves them.
"""

import contextlib
import hmac
import http
import io
import logging
import math
import secrets
import threading
import warnings
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, quote, unquote, urlsplit

import viser
import viser._messages as messages
import viser.infra._infra as infra
import websockets.asyncio.server
from viser.infra import Message
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from ao2viz.ui.shelf import MAX_UPLOAD_BYTES

MAX_MESSAGE_BYTES = 1_000_000
"""People send clicks and short texts; nothing near this."""
MAX_TEXT = 2_000
"""Characters in a text field; more are ignored. Fields tell earlier what is too long for them."""
MAX_FILE_NAME = 255
"""Characters in the name of an uploaded file."""
MAX_UPLOADS = 2
"""Files that one browser may be sending at a time."""
MAX_BROWSERS = 32
"""More at a time are turned away."""

# Browsers send files in parts of half a MiB; more parts than that would only fill the memory.
_SMALLEST_PART = 2**18
_LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
_COOKIE = "ao2viz_token"
_PLACE_COOKIE = "ao2viz_place"
_MAX_PLACE = 1_000  # Characters of a page's query that are handed on.
_LARGEST = 1e300
# Everything a browser needs to say; the share tunnel and forms are not among it.
_ALLOWED = (
    messages.ViewerCameraMessage,
    messages.GuiUpdateMessage,
    messages.ScenePointerMessage,
    messages.CommandTriggerMessage,
    messages.FileTransferStartUpload,
    messages.FileTransferPart,
    messages.LocalStorageGetItemResponseMessage,
)
_query: ContextVar[str] = ContextVar("query", default="")
_value: ContextVar[Any] = ContextVar("value")
_constructing = threading.Lock()  # `serve` is swapped for the whole process while one is built.


class Gate:
    """Decides about a handshake from its headers alone."""

    def __init__(self, host: str, token: str | None) -> None:
        """Makes a gate.

        Args:
            host: What the server listens on.
            token: Must be in the address if given.
        """
        self._is_local = host in _LOOPBACK
        self._token = token

    def refuse(self, path: str, headers: Headers, n_connected: int) -> tuple[int, str] | None:
        """HTTP status and words if the request must be turned away, else None."""
        is_socket = (headers.get("Upgrade") or "").lower() == "websocket"
        try:
            host, origin = headers["Host"], headers.get("Origin")
        except (KeyError, LookupError):
            return 400, "A request names its host exactly once."
        if self._is_local and _hostname(host) not in _LOOPBACK:
            # A page elsewhere can point its own name at this computer (DNS rebinding).
            return 403, f"This dashboard answers to localhost only, not to {_hostname(host)!r}."
        if is_socket and origin is None:
            return 403, "Only browsers may connect: the request has no Origin."
        if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            return 403, "Refused: the request comes from another site."
        if not self.has_token(path, headers):
            return 403, "This dashboard needs the token of the address that ao2viz printed."
        if is_socket and n_connected >= MAX_BROWSERS:
            return 503, f"{MAX_BROWSERS} browsers are connected already; close one."
        return None

    def has_token(self, path: str, headers: Headers) -> bool:
        """Whether the address or a cookie we gave carries the token, if one is asked for."""
        if self._token is None:
            return True
        given = parse_qs(urlsplit(path).query).get("token", [])
        with contextlib.suppress(CookieError):
            for header in headers.get_all("Cookie"):
                morsel = SimpleCookie(header).get(_COOKIE)
                given += [morsel.value] if morsel is not None else []
        return any(hmac.compare_digest(g.encode(), self._token.encode()) for g in given)

    def query_of(self, path: str, headers: Headers) -> str:
        """What the address of the page asks for; `welcome` left it in a cookie. From anybody."""
        own = urlsplit(path).query
        if own:
            return own[:_MAX_PLACE]
        with contextlib.suppress(CookieError):
            for header in headers.get_all("Cookie"):
                morsel = SimpleCookie(header).get(_PLACE_COOKIE)
                if morsel is not None:
                    return unquote(morsel.value)[:_MAX_PLACE]
        return ""

    def welcome(self, path: str, response: Response) -> Response:
        """Adds what keeps the page safe in the browser, and the cookie that carries the token."""
        response.headers["X-Frame-Options"] = "DENY"
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "no-referrer"
        if self._token is not None and "token" in parse_qs(urlsplit(path).query):
            response.headers["Set-Cookie"] = (
                f"{_COOKIE}={self._token}; HttpOnly; SameSite=Lax; Path=/"
            )
        asked = urlsplit(path)
        if asked.path in ("", "/"):  # The page's own handshake does not carry its query.
            query = quote(asked.query[:_MAX_PLACE], safe="")
            response.headers["Set-Cookie"] = (
                f"{_PLACE_COOKIE}={query}; HttpOnly; SameSite=Strict; Path=/"
            )
        return response


def asked_query() -> str:
    """What the address of the browser that connects asks for; only within `on_client_connect`."""
    return _query.get()


def set_value() -> Any:
    """What a person has set a control to; only within its `on_update`, awaited.

    The control itself may show something else by then, which another thread has assigned.
    """
    return _value.get()


def make_token() -> str:
    """A token nobody guesses."""
    return secrets.token_urlsafe(24)


def make_server(host: str, port: int, token: str | None = None) -> viser.ViserServer:
    """A viser server behind the gate; it prints nothing.

    Raises:
        ValueError: If it would listen to the network without a token.
    """
    if host not in _LOOPBACK and not token:
        raise ValueError(
            f"Listening on {host} opens the dashboard to the network; it needs a token for that."
        )
    gate = Gate(host, token)
    with _constructing, _guarded_serve(gate), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, label="ao2viz", verbose=False)
    _filter_messages(server)
    # A browser may go while its screen is being brought up to date; that is nobody's mistake.
    warnings.filterwarnings("ignore", r"Queued a \w+ on a closed connection", UserWarning)
    return server


@contextlib.contextmanager
def _guarded_serve(gate: Gate) -> Iterator[None]:
    """Lets servers that start meanwhile ask the gate about every handshake."""
    serve = websockets.asyncio.server.serve

    def guarded(
        handler: Any,
        host: str,
        port: int,
        *,
        process_request: Callable[[Any, Request], Response | None],
        **options: Any,
    ) -> Any:
        n_connected = 0

        def ask_gate(connection: Any, request: Request) -> Response | None:
            refusal = gate.refuse(request.path, request.headers, n_connected)
            if refusal is not None:
                return _plain(*refusal)
            response = process_request(connection, request)
            return response if response is None else gate.welcome(request.path, response)

        async def counted(connection: Any) -> None:
            nonlocal n_connected
            n_connected += 1
            _query.set(gate.query_of(connection.request.path, connection.request.headers))
            try:
                await handler(connection)
            finally:
                n_connected -= 1

        options["max_size"] = MAX_MESSAGE_BYTES
        return serve(counted, host, port, process_request=ask_gate, **options)

    websockets.asyncio.server.serve = guarded
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve
    # Refused handshakes are ordinary here; websockets would log each with a traceback.
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)


def _plain(status: int, text: str) -> Response:
    body = (text + "\n").encode()
    headers = Headers()
    headers["Content-Type"] = "text/plain; charset=utf-8"
    headers["Content-Length"] = str(len(body))
    headers["Connection"] = "close"
    return Response(status, http.HTTPStatus(status).phrase, headers, body)


def _hostname(host: str) -> str:
    try:
        return (urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:
        return ""


def _filter_messages(server: viser.ViserServer) -> None:
    """Puts a filter in front of the handlers of the server and of each coming browser."""
    _guard(server._websock_server, server.gui)

    @server._websock_server.on_client_connect
    def _(connection: infra.WebsockClientConnection) -> None:
        # Viser has registered its own handlers by now; they stay behind the filter.
        _guard(connection, None)

    @server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        _guard(client.gui._websock_interface, client.gui)


def _guard(handler: infra.WebsockMessageHandler, gui: viser.GuiApi | None) -> None:
    """Lets through what `is_harmless`; without a GuiApi no value can be set at all."""
    behind = type(handler)._handle_incoming_message

    async def filtered(client_id: infra.ClientId, message: Message) -> None:
        if is_harmless(message, gui):
            if isinstance(message, messages.GuiUpdateMessage):
                _value.set(message.updates["value"])
            await behind(handler, client_id, message)

    handler._handle_incoming_message = filtered


def is_harmless(message: object, gui: viser.GuiApi | None) -> bool:
    """Whether a browser may say this: known kinds only, and only values that a control offers."""
    if type(message) not in _ALLOWED:
        return False
    if isinstance(message, messages.FileTransferStartUpload):
        return gui is not None and _may_begin(message, gui)
    if isinstance(message, messages.FileTransferPart):
        return gui is not None and _is_next_part(message, gui)
    if not isinstance(message, messages.GuiUpdateMessage):
        return True
    if gui is None or not isinstance(message.uuid, str) or set(message.updates) != {"value"}:
        return False
    handle = gui._gui_input_handle_from_uuid.get(message.uuid)
    return handle is not None and is_offered(handle, message.updates["value"])


def _may_begin(message: messages.FileTransferStartUpload, gui: viser.GuiApi) -> bool:
    """Whether an upload button asked for this file, and it is not too big."""
    handle = gui._gui_input_handle_from_uuid.get(str(message.source_component_uuid))
    if not isinstance(handle, viser.GuiUploadButtonHandle) or handle.disabled or not handle.visible:
        return False
    size, parts = message.size_bytes, message.part_count
    if not (isinstance(size, int) and isinstance(parts, int) and 0 < size <= MAX_UPLOAD_BYTES):
        return False
    states = gui._current_file_upload_states
    while len(states) >= MAX_UPLOADS:  # The oldest was given up; a browser tells of no such thing.
        states.pop(next(iter(states)))
    return 0 < parts <= 1 + size // _SMALLEST_PART and len(str(message.filename)) <= MAX_FILE_NAME


def _is_next_part(message: messages.FileTransferPart, gui: viser.GuiApi) -> bool:
    """Whether this belongs to a file on its way, and leaves it as big as was said."""
    state = gui._current_file_upload_states.get(message.transfer_uuid)
    if state is None or not isinstance(message.content, bytes) or not message.content:
        return False
    return state["transferred_bytes"] + len(message.content) <= state["total_bytes"]


def is_offered(handle: Any, value: object) -> bool:
    """Whether a person could have set the control to this value."""
    if getattr(handle, "disabled", False) or not handle.visible:
        return False
    match handle:
        case viser.GuiButtonHandle():
            return value is True
        case viser.GuiCheckboxHandle():
            return isinstance(value, bool)
        case viser.GuiDropdownHandle() | viser.GuiButtonGroupHandle():
            return isinstance(value, str) and value in handle.options
        case viser.GuiTextHandle():
            return isinstance(value, str) and len(value) <= MAX_TEXT
        case viser.GuiSliderHandle() | viser.GuiNumberHandle():
            return _is_number_for(handle, value)
        case _:  # Uploads and all else that the dashboard does not have.
            return False


def _is_number_for(handle: Any, value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    if not abs(value) <= _LARGEST:  # Neither is NaN, which compares with nothing.
        return False
    if isinstance(handle.value, int) and value != int(value):
        return False
    low = handle.min if handle.min is not None else -math.inf
    high = handle.max if handle.max is not None else math.inf
    return low <= value <= high
