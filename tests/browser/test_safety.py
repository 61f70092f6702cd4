"""What a browser on a hostile page, or in the network, gets to see."""

import http.server
import threading
from pathlib import Path

from ao2viz.training.runner import ThreadRunner
from ao2viz.ui.app import Dashboard
from tests.browser.conftest import SIZE, Open

_ATTACK = """<!doctype html><title>evil</title><script>
const socket = new WebSocket("ws://127.0.0.1:%d/", ["viser-v1.1.1"]);
socket.onopen = () => { document.title = "open"; };
socket.onerror = () => { document.title = "refused"; };
</script>"""


def test_a_page_from_elsewhere_cannot_connect(dashboard, browser):
    class Evil(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write((_ATTACK % dashboard.port).encode())

        def log_message(self, *_: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Evil)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    page = browser.new_page()
    try:
        page.goto(f"http://127.0.0.1:{server.server_port}/")
        page.wait_for_function("document.title !== 'evil'", timeout=20_000)
        assert page.title() == "refused"
        assert dashboard.views == {}
    finally:
        page.close()
        server.shutdown()


def test_the_printed_address_opens_a_page_for_the_network(
    shipped: Path, tmp_path: Path, open_window: Open, browser
):
    dashboard = Dashboard(
        host="0.0.0.0", port=0, shipped=shipped, folder=tmp_path, make_runner=ThreadRunner
    )
    dashboard.start()
    try:
        assert "?token=" in dashboard.address
        window = open_window(dashboard)
        window.wait(lambda: window.view.transport.position > 0, "the episode to play")
        stranger = browser.new_context(viewport=SIZE)
        page = stranger.new_page()
        answer = page.goto(dashboard.address.split("?")[0])
        assert answer is not None
        assert answer.status == 403
        assert "token" in page.inner_text("body")
        stranger.close()
    finally:
        dashboard.stop()
