"""What the gate lets through of files: only what an upload button may get, and no more of it."""

from collections.abc import Iterator

import pytest
import viser
import viser._messages as messages

from ao2viz.ui.security import MAX_TEXT, MAX_UPLOADS, is_harmless, make_server
from ao2viz.ui.shelf import MAX_UPLOAD_BYTES

PART = 512 * 1024


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    made = make_server("127.0.0.1", 0)
    yield made
    made.stop()


def begin(handle, *, size=PART, parts=1, name="a.ao2", transfer="t"):
    uuid = handle if isinstance(handle, str) else handle._impl.uuid
    return messages.FileTransferStartUpload(uuid, transfer, name, "x/y", parts, size)


def test_a_file_begins_only_at_an_upload_button_and_within_its_limits(server):
    gui = server.gui
    upload = gui.add_upload_button("Upload")
    assert is_harmless(begin(upload), gui)
    assert is_harmless(begin(upload, size=MAX_UPLOAD_BYTES, parts=MAX_UPLOAD_BYTES // PART), gui)
    for bad in (
        begin(upload, size=MAX_UPLOAD_BYTES + 1),
        begin(upload, size=0, parts=0),
        begin(upload, size=-5),
        begin(upload, parts=0),
        begin(upload, parts=10_000),
        begin(upload, name="x" * (MAX_TEXT + 1)),
        begin(upload, size="many"),
        begin(gui.add_button("No file")),
        begin("nobody"),
    ):
        assert not is_harmless(bad, gui)
    assert not is_harmless(begin(upload), None)
    upload.disabled = True
    assert not is_harmless(begin(upload), gui)


def test_parts_belong_to_a_file_and_never_exceed_its_size(server):
    gui = server.gui
    upload = gui.add_upload_button("Upload")
    assert not is_harmless(messages.FileTransferPart(None, "t", 0, b"x"), gui)
    gui._handle_file_transfer_start(0, begin(upload, size=10, parts=2))
    assert is_harmless(messages.FileTransferPart(None, "t", 0, b"x" * 10), gui)
    for content in (b"x" * 11, b"", "words"):
        assert not is_harmless(messages.FileTransferPart(None, "t", 0, content), gui)
    gui._handle_file_transfer_part(0, messages.FileTransferPart(None, "t", 0, b"x" * 6))
    assert not is_harmless(messages.FileTransferPart(None, "t", 1, b"x" * 5), gui)
    assert is_harmless(messages.FileTransferPart(None, "t", 1, b"x" * 4), gui)


def test_files_that_were_given_up_do_not_pile_up(server):
    gui = server.gui
    upload = gui.add_upload_button("Upload")
    for number in range(20):
        message = begin(upload, size=MAX_UPLOAD_BYTES, parts=128, transfer=f"t{number}")
        assert is_harmless(message, gui)
        gui._handle_file_transfer_start(0, message)
    assert len(gui._current_file_upload_states) <= MAX_UPLOADS
