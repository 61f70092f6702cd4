"""Who may connect and what they may say, against a real server; and what of viser this rests on."""

import asyncio
import http.client
import inspect
import math
import time
from collections.abc import Iterator

import msgspec
import pytest
import viser
import viser._messages as messages
import viser.infra._infra as infra
import websockets
import websockets.asyncio.client
import websockets.asyncio.server
from websockets.exceptions import InvalidStatus

from ao2viz.ui import security
from ao2viz.ui.commands import Seek
from ao2viz.ui.inbox import Inbox, on_change
from ao2viz.ui.security import is_harmless, is_offered, make_server

SUBPROTOCOL = websockets.Subprotocol(f"viser-v{viser.__version__}")


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    made = make_server("127.0.0.1", 0)
    yield made
    made.stop()


@pytest.fixture(scope="module")
def open_server() -> Iterator[viser.ViserServer]:
    made = make_server("0.0.0.0", 0, "s3cret")
    yield made
    made.stop()


def shake_hands(port: int, origin: str | None, path: str = "", **headers: str) -> int:
    """The status of a websocket handshake; 101 if it worked."""

    async def connect() -> int:
        try:
            async with websockets.asyncio.client.connect(
                f"ws://127.0.0.1:{port}/{path}",
                origin=origin,  # pyright: ignore[reportArgumentType]
                subprotocols=[SUBPROTOCOL],
                additional_headers=headers,
            ):
                return 101
        except InvalidStatus as refused:
            return refused.response.status_code

    return asyncio.run(connect())


def get(port: int, path: str = "/", host: str | None = None, **headers: str):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    connection.putrequest("GET", path, skip_host=host is not None)
    if host is not None:
        connection.putheader("Host", host)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    return connection.getresponse()


def test_it_listens_on_this_computer_only(server):
    sockets = server._websock_server
    assert server.get_host() == "127.0.0.1"
    assert sockets._host == "127.0.0.1"


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost"])
def test_the_own_page_connects(server, name):
    port = server.get_port()
    assert shake_hands(port, f"http://{name}:{port}", Host=f"{name}:{port}") in (101, 400)
    assert shake_hands(port, f"http://127.0.0.1:{port}") == 101


@pytest.mark.parametrize(
    "origin",
    [
        "https://evil.example",
        "http://localhost.evil.com:{port}",
        "http://127.0.0.1.evil.com:{port}",
        "http://127.0.0.1:1",
        "http://localhost:{port}",  # Another site than the one that is asked.
        "null",
        "",
        None,
    ],
)
def test_a_foreign_origin_is_refused(server, origin):
    port = server.get_port()
    origin = origin.format(port=port) if origin else origin
    assert shake_hands(port, origin) == 403


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "localhost.evil.com", "[bad"])
def test_a_name_pointed_at_this_computer_is_refused(server, host):
    answer = get(server.get_port(), host=host)
    assert answer.status == 403
    assert b"localhost only" in answer.read()


def test_the_page_cannot_be_framed(server):
    answer = get(server.get_port())
    assert answer.status == 200
    assert answer.getheader("X-Frame-Options") == "DENY"
    assert answer.getheader("X-Content-Type-Options") == "nosniff"


def test_the_network_needs_a_token():
    with pytest.raises(ValueError, match="needs a token"):
        make_server("0.0.0.0", 0)


@pytest.mark.parametrize("path", ["/", "/?token=wrong", "/?token=", "/?token=s3cre"])
def test_without_the_token_there_is_no_page(open_server, path):
    answer = get(open_server.get_port(), path)
    assert answer.status == 403
    assert b"token" in answer.read()


def test_without_the_token_there_is_no_connection(open_server):
    port = open_server.get_port()
    assert shake_hands(port, f"http://127.0.0.1:{port}") == 403


def test_the_address_with_the_token_opens_the_page_which_then_connects(open_server):
    port = open_server.get_port()
    answer = get(port, "/?token=s3cret")
    assert answer.status == 200
    cookie = answer.getheader("Set-Cookie")
    assert cookie is not None
    assert "HttpOnly" in cookie
    assert "SameSite" in cookie
    sent = cookie.split(";")[0]
    assert shake_hands(port, f"http://127.0.0.1:{port}", Cookie=sent) == 101
    assert shake_hands(port, "https://evil.example", Cookie=sent) == 403


def test_tokens_are_long_and_never_the_same():
    assert len({security.make_token() for _ in range(50)}) == 50
    assert len(security.make_token()) >= 32


def test_only_so_many_browsers_connect(monkeypatch):
    monkeypatch.setattr(security, "MAX_BROWSERS", 2)
    server = make_server("127.0.0.1", 0)
    port = server.get_port()

    async def connect_three() -> int:
        def connect():
            return websockets.asyncio.client.connect(
                f"ws://127.0.0.1:{port}",
                origin=f"http://127.0.0.1:{port}",  # pyright: ignore[reportArgumentType]
                subprotocols=[SUBPROTOCOL],
            )

        async with connect(), connect():
            with pytest.raises(InvalidStatus, match="503") as refused:
                await connect()
            return refused.value.response.status_code

    assert asyncio.run(connect_three()) == 503
    server.stop()


def say(port: int, *said: dict) -> None:
    """Connects like a browser, says something, and stays for a moment."""

    async def talk() -> None:
        async with websockets.asyncio.client.connect(
            f"ws://127.0.0.1:{port}",
            origin=f"http://127.0.0.1:{port}",  # pyright: ignore[reportArgumentType]
            subprotocols=[SUBPROTOCOL],
        ) as connection:
            for message in said:
                await connection.send(msgspec.msgpack.encode(message))
            await asyncio.sleep(0.5)

    asyncio.run(talk())


CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1, 0, 0, 0],
    "position": [0, 0, 1],
    "fov": 1.0,
    "image_height": 10,
    "image_width": 10,
    "near": 0.1,
    "far": 10,
    "look_at": [0, 0, 0],
    "up_direction": [0, 1, 0],
}


def test_nobody_can_ask_for_a_share_tunnel(server, monkeypatch):
    asked = []
    monkeypatch.setattr(server, "request_share_url", lambda *_: asked.append(1))
    say(server.get_port(), CAMERA, {"type": "ShareUrlRequest"}, {"type": "ShareUrlDisconnect"})
    assert asked == []


def test_only_offered_values_reach_a_handle_over_the_wire(server):
    slider = server.gui.add_slider("Step", 0, 10, 1, 5)
    seen = []
    slider.on_update(lambda event: seen.append(event.target.value))
    uuid = slider._impl.uuid

    def update(**updates: object) -> dict:
        return {"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates}

    hostile = [update(value=v) for v in (99999, -1, "7", True, None, [1], 2.5)]
    hostile += [update(max=1e9), update(value=6, max=99), update(visible=False), update()]
    say(server.get_port(), CAMERA, *hostile)
    assert slider.value == 5
    assert (slider.max, slider.visible, seen) == (10, True, [])
    say(server.get_port(), CAMERA, update(value=6))
    deadline = time.monotonic() + 5
    while slider.value != 6 and time.monotonic() < deadline:
        time.sleep(0.05)
    assert slider.value == 6


def test_what_a_person_sets_is_taken_though_a_playing_episode_moves_the_control_on(server):
    slider, inbox = server.gui.add_slider("Step", 0, 100, 1, 5), Inbox()

    @slider.on_update
    async def _(event: viser.GuiEvent) -> None:
        if event.client is not None:
            slider.value = 17  # As the app loop may, in a thread of its own.

    on_change(slider, Seek, 1, inbox)
    update = {"type": "GuiUpdateMessage", "uuid": slider._impl.uuid, "updates": {"value": 3}}
    say(server.get_port(), CAMERA, update)
    inbox.wait(5.0)
    assert inbox.drain() == [(1, Seek(3))]
    assert slider.value == 17


def test_a_browser_reaches_its_own_handles_and_nobody_elses():
    """Two browsers: the second knows the id of the first one's slider and may not move it."""
    server, made = make_server("127.0.0.1", 0), []

    @server.on_client_connect
    def _(client: viser.ClientHandle) -> None:
        made.append(client.gui.add_slider("Step", 0, 10, 1, 5))

    async def talk() -> None:
        def connect():
            return websockets.asyncio.client.connect(
                f"ws://127.0.0.1:{server.get_port()}",
                origin=f"http://127.0.0.1:{server.get_port()}",  # pyright: ignore[reportArgumentType]
                subprotocols=[SUBPROTOCOL],
            )

        async with connect() as one, connect() as two:
            await one.send(msgspec.msgpack.encode(CAMERA))
            while len(made) < 1:
                await asyncio.sleep(0.05)
            await two.send(msgspec.msgpack.encode(CAMERA))
            while len(made) < 2:
                await asyncio.sleep(0.05)
            message = {
                "type": "GuiUpdateMessage",
                "uuid": made[0]._impl.uuid,
                "updates": {"value": 9},
            }
            await two.send(msgspec.msgpack.encode(message))
            await asyncio.sleep(0.3)
            assert made[0].value == 5
            await one.send(msgspec.msgpack.encode(message))
            while made[0].value != 9:
                await asyncio.sleep(0.05)

    asyncio.run(asyncio.wait_for(talk(), 30))
    server.stop()


def test_huge_messages_end_the_connection(server):
    async def shout() -> int | None:
        async with websockets.asyncio.client.connect(
            f"ws://127.0.0.1:{server.get_port()}",
            origin=f"http://127.0.0.1:{server.get_port()}",  # pyright: ignore[reportArgumentType]
            subprotocols=[SUBPROTOCOL],
        ) as connection:
            await connection.send(b"x" * (security.MAX_MESSAGE_BYTES + 1))
            await asyncio.wait_for(connection.wait_closed(), 10)
            return connection.close_code

    assert asyncio.run(shout()) == 1009


@pytest.mark.parametrize(
    "message",
    [
        messages.ShareUrlRequest(),
        messages.ShareUrlDisconnect(),
        messages.GuiFormSubmitMessage(uuid="x"),
        messages.FileTransferStartUpload("x", "y", "../../etc/passwd", "text/plain", 1, 9),
        messages.RunJavascriptMessage("alert(1)"),
    ],
)
def test_all_but_the_known_kinds_of_messages_are_dropped(server, message):
    assert not is_harmless(message, server.gui)


def test_nothing_can_be_set_before_the_panels_are_there():
    assert not is_harmless(messages.GuiUpdateMessage("x", {"value": 1}), None)


def test_values_are_what_a_person_could_have_chosen(server):
    gui = server.gui
    number = gui.add_number("Seed", 3, min=0, max=9, step=1)
    real = gui.add_number("Real", 0.5)
    text = gui.add_text("Text", "")
    choice = gui.add_dropdown("Choice", ("a", "b"))
    button = gui.add_button("Go")
    off = gui.add_button("Off", disabled=True)
    hidden = gui.add_text("Hidden", "", visible=False)
    box = gui.add_checkbox("Box", False)
    upload = gui.add_upload_button("Up")
    good = [(number, 9), (real, -1e30), (real, 2), (text, "x" * 2_000), (choice, "b")]
    good += [(button, True), (box, False)]
    bad = [(number, 10), (number, 2.5), (number, math.nan), (real, math.inf), (real, "1")]
    bad += [(text, "x" * 2_001), (text, 5), (choice, "c"), (choice, ["a"]), (button, False)]
    bad += [(button, 1), (off, True), (hidden, "x"), (box, 1), (upload, b"x"), (number, 10**400)]
    for handle, value in good:
        assert is_offered(handle, value), (handle.label, value)
    for handle, value in bad:
        assert not is_offered(handle, value), (handle.label, value)


def test_viser_still_has_the_private_things_that_this_rests_on():
    assert viser.__version__.startswith("1.1.")
    serve = inspect.getsource(infra.WebsockServer._background_worker)
    assert "websockets.asyncio.server.serve(" in serve
    assert "self._handle_incoming_message(client_id, message)" in serve
    assert "client_connection._handle_incoming_message(client_id, message)" in serve
    assert inspect.iscoroutinefunction(infra.WebsockMessageHandler._handle_incoming_message)
    gui = inspect.getsource(viser.GuiApi.__init__)
    assert "_gui_input_handle_from_uuid" in gui
    assert "_websock_interface" in gui
    image = inspect.getsource(viser.GuiImageHandle.image.fset)
    assert "self._data = data" in image


def test_serve_is_itself_again_afterwards(server):
    assert websockets.asyncio.server.serve.__module__.startswith("websockets")


def test_a_browser_that_goes_while_something_is_sent_causes_no_warning(recwarn):
    server = make_server("127.0.0.1", 0)
    words = server.gui.add_html("here")
    server.stop()
    words.content = "gone"
    assert [str(one.message) for one in recwarn if "closed connection" in str(one.message)] == []
