"""Counts what a page receives: a door in front of a server that passes everything on."""

import contextlib
import socket
import threading

_AT_A_TIME = 2**18
_SOCKET = b"upgrade: websocket"


class Wire:
    """Listens on a port of its own and passes bytes to and from another one, both unchanged.

    What comes down websockets is counted, all connections together; the page's own files are not.
    """

    def __init__(self, port: int) -> None:
        """Opens the door to a port of this machine."""
        self._to = port
        self.received = 0  # Bytes that browsers got over websockets so far.
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._counting = threading.Lock()
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def port(self) -> int:
        """Where it listens."""
        return self._listener.getsockname()[1]

    def close(self) -> None:
        """Lets nobody else in."""
        self._listener.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                browser, _ = self._listener.accept()
                threading.Thread(target=self._pass_on, args=(browser,), daemon=True).start()

    def _pass_on(self, browser: socket.socket) -> None:
        server = socket.create_connection(("127.0.0.1", self._to))
        for end in (browser, server):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with browser, server, contextlib.suppress(OSError):
            request = browser.recv(_AT_A_TIME)
            server.sendall(request)
            is_socket = _SOCKET in request.lower()
            back = threading.Thread(target=self._down, args=(server, browser, is_socket))
            back.start()
            while chunk := browser.recv(_AT_A_TIME):
                server.sendall(chunk)
            server.shutdown(socket.SHUT_WR)
            back.join()

    def _down(self, server: socket.socket, browser: socket.socket, is_socket: bool) -> None:
        with contextlib.suppress(OSError):
            while chunk := server.recv(_AT_A_TIME):
                if is_socket:
                    with self._counting:
                        self.received += len(chunk)
                browser.sendall(chunk)
            browser.shutdown(socket.SHUT_WR)
