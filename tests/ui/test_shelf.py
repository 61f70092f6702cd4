"""Agent files on the page: where they may go, what is checked, what is asked."""

import time
from dataclasses import replace
from pathlib import Path

import pytest

from ao2viz.agent import AO2
from ao2viz.store.errors import AgentFileError
from ao2viz.store.files import keep, read
from ao2viz.training.states import RunStatus, Save
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.commands import Edit, Field, Press, RunButton
from ao2viz.ui.copies import Copies, read_agent
from ao2viz.ui.dialog_commands import ChooseFolder, ConfirmUpload, DownloadAgent, Uploaded
from ao2viz.ui.downloads import Notify, SaveFile
from ao2viz.ui.library import Library
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session, Upload
from ao2viz.ui.shelf import MAX_UPLOAD_BYTES, KeepUpload, SendAgent
from ao2viz.ui.world import ShelfItem, World


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("made") / "a.ao2"
    AO2("CartPole-v1", seed=0, warmup_steps=20, levels=1).learn(60).save(path)
    return path.read_bytes()


@pytest.fixture
def world(tmp_path: Path) -> World:
    one, two = tmp_path / "one", tmp_path / "two"
    one.mkdir()
    two.mkdir()
    return World(folder=one, folders=(one, two))


def told(effects: tuple) -> str:
    assert len(effects) == 1
    assert isinstance(effects[0], Notify)
    return effects[0].body


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("grown.ao2", "grown"),
        ("../../etc/grown.ao2", "grown"),
        ("/tmp/grown.ao2", "grown"),
        ("C:\\Users\\me\\grown.ao2", "grown"),
    ],
)
def test_an_upload_goes_into_the_folder_whatever_path_it_claims(name, stem, world):
    _, effects = reduce(Session(), Uploaded(name, b"x"), world)
    assert effects == (KeepUpload(Upload(world.folder / f"{stem}.ao2", b"x")),)


@pytest.mark.parametrize(
    ("name", "size", "words"),
    [
        ("virus.exe", 1, "ends in .ao2"),
        ("..", 1, "ends in .ao2"),
        ("", 1, "ends in .ao2"),
        (".ao2", 1, "A file name is up to 80 letters"),
        ("..ao2", 1, "A file name is up to 80 letters"),
        ("a\nb.ao2", 1, "A file name is up to 80 letters"),
        ("x" * 90 + ".ao2", 1, "A file name is up to 80 letters"),
        ("big.ao2", MAX_UPLOAD_BYTES + 1, "at most 64 MiB"),
    ],
)
def test_what_is_no_agent_by_name_or_size_is_refused(name, size, words, world):
    session, effects = reduce(Session(), Uploaded(name, bytes(size)), world)
    assert words in told(effects)
    assert session == Session()


def test_replacing_a_file_by_an_upload_asks_first(world):
    (world.folder / "a.ao2").write_bytes(b"old")
    asked, effects = reduce(Session(), Uploaded("a.ao2", b"new"), world)
    assert effects == ()
    assert asked.upload is not None
    kept, effects = reduce(asked, ConfirmUpload(False), world)
    assert (kept.upload, effects) == (None, ())
    replaced, effects = reduce(asked, ConfirmUpload(True), world)
    assert replaced.upload is None
    assert effects == (KeepUpload(Upload(world.folder / "a.ao2", b"new")),)
    assert reduce(Session(), ConfirmUpload(True), world)[1] == ()


def test_agents_go_to_an_allowed_folder_only(world, tmp_path):
    running = replace(world, update=RunUpdate(RunStatus.PAUSED))
    for folder, expected in ((world.folders[1], world.folders[1]), (tmp_path, world.folder)):
        session, _ = reduce(Session(), ChooseFolder(folder), running)
        session, _ = reduce(session, Edit(Field.FILE_NAME, "mine"), running)
        _, effects = reduce(session, Press(RunButton.SAVE), running)
        assert effects == (Save(expected / "mine.ao2"),)
        _, effects = reduce(session, Uploaded("mine.ao2", b"x"), running)
        assert effects[0].upload.path == expected / "mine.ao2"


def test_only_what_stands_on_the_shelf_can_be_downloaded(world, tmp_path):
    path = tmp_path / "one" / "a.ao2"
    shelved = replace(world, shelf=(ShelfItem(path, "a"),))
    assert reduce(Session(), DownloadAgent(path), shelved)[1] == (SendAgent(path),)
    secret = tmp_path / "secret.ao2"
    assert "not on the shelf" in told(reduce(Session(), DownloadAgent(secret), shelved)[1])
    assert "no run" in told(reduce(Session(), DownloadAgent(None), shelved)[1])
    held = replace(world, update=RunUpdate(RunStatus.PAUSED))
    assert reduce(Session(), DownloadAgent(None), held)[1] == (SendAgent(None),)


def test_an_upload_is_read_in_full_before_it_is_kept(content, tmp_path):
    path = tmp_path / "new" / "a.ao2"
    saved = keep(path, content)
    assert path.read_bytes() == content
    assert read(path).n_steps == saved.n_steps == 60
    broken = bytearray(content)
    broken[len(broken) // 2] ^= 0xFF
    for bad in (b"", b"PK\x05\x06", bytes(broken), content[:-10], content + b"x"):
        with pytest.raises(AgentFileError, match=r"Could not open 'a.ao2'"):
            keep(path, bad)
        assert path.read_bytes() == content
    assert [p.name for p in path.parent.iterdir()] == ["a.ao2"]


def test_the_library_tells_whoever_sent_a_file_what_became_of_it(content, tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    library = Library(tmp_path / "none", one, None, (two,))
    library.keep(7, Upload(one / "good.ao2", content))
    library.keep(8, Upload(two / "bad.ao2", content[:100]))
    notices, deadline = [], time.monotonic() + 60
    while len(notices) < 2 and time.monotonic() < deadline:
        notices += library.poll_kept()
    library.close()
    assert {(who, n.title, n.is_error) for who, n in notices} == {
        (7, "Uploaded", False),
        (8, "Not uploaded", True),
    }
    assert [item.label for item in library.shelf()] == ["good"]
    assert not (two / "bad.ao2").exists()


def test_a_copy_of_the_run_is_sent_once_it_is_whole_and_leaves_nothing_behind(content, tmp_path):
    copies = Copies(tmp_path)
    save = copies.ask(3, RunUpdate(RunStatus.RUNNING, n_steps=60, seed=4))
    assert save.is_copy
    assert save.path.parent == tmp_path
    assert copies.poll(0.0) == copies.poll(1.0) == []
    save.path.write_bytes(content)
    ((who, file),) = copies.poll(2.0)
    assert (who, file) == (3, SaveFile("agent-anticipating-seed4-60.ao2", content))
    assert list(tmp_path.iterdir()) == []
    assert copies.poll(3.0) == []
    copies.ask(3, RunUpdate())
    assert copies.poll(10.0) == []
    ((_, notice),) = copies.poll(100.0)
    assert "in time" in notice.body


def test_files_that_cannot_be_sent_are_told_in_words(tmp_path):
    assert "cannot be read" in read_agent(tmp_path / "gone.ao2").body
    big = tmp_path / "big.ao2"
    with open(big, "wb") as stream:
        stream.truncate(MAX_UPLOAD_BYTES + 1)
    assert str(big) in read_agent(big).body
