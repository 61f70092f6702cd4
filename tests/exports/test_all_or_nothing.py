"""Every format, called off, out of space or in a forbidden place: whole, or not at all."""

import contextlib
import os
import resource
from collections.abc import Iterator
from pathlib import Path

import pytest

import ao2viz
from ao2viz import Format
from ao2viz.exports.formats import ABOUT
from tests.exports.agents import brief


class CalledOff(BaseException):
    """Nothing that an export could take for an error of its own."""


def write(path: Path, format: Format, **more) -> Path:
    return ao2viz.export(brief(), path, format, option=0, **more)


@contextlib.contextmanager
def disk_with_room_for(n_bytes: int) -> Iterator[None]:
    """No file of this process may grow further: for who writes, that is a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def content_of(path: Path) -> dict[str, bytes]:
    parts = [path, *path.rglob("*")]
    return {str(part.relative_to(path)): part.read_bytes() for part in parts if part.is_file()}


@pytest.mark.parametrize("format", Format)
def test_whatever_ends_it_what_was_there_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, format: Format
) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(elsewhere))
    shares: list[float] = []
    old = write(tmp_path / "old", format, progress=shares.append)
    assert shares == sorted(set(shares))
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    before = content_of(old)
    # A folder is never replaced, so that there only a new one can be half.
    place = tmp_path / "new" if ABOUT[format].is_folder else old

    def assert_nothing_happened() -> None:
        assert sorted(entry.name for entry in tmp_path.iterdir()) == ["elsewhere", "old"]
        assert list(elsewhere.iterdir()) == []
        assert content_of(old) == before

    for moment in sorted({0, 1, len(shares) // 2, len(shares) - 1}):
        told: list[float] = []

        def stop(share: float, told: list[float] = told, moment: int = moment) -> None:
            told.append(share)
            if len(told) > moment:
                raise CalledOff(moment)

        with pytest.raises(CalledOff, match=f"^{moment}$"):
            write(place, format, progress=stop, overwrite=place == old)
        assert told == shares[: moment + 1]
        assert_nothing_happened()

    for room in (0, max(map(len, before.values())) // 2):
        with (
            disk_with_room_for(room),
            pytest.raises(OSError, match=rf"^\[Errno \d+\] File too large: '{place}'$"),
        ):
            write(place, format, overwrite=place == old)
        assert_nothing_happened()


@pytest.fixture
def forbidden(tmp_path: Path) -> Iterator[Path]:
    """A folder in which nothing can be made."""
    if os.geteuid() == 0:  # Permissions do not count for root, but nobody makes files there.
        if not Path("/proc").is_dir():
            pytest.skip("There is no folder here that even root cannot write to.")
        yield Path("/proc")
        return
    tmp_path.chmod(0o500)
    yield tmp_path
    tmp_path.chmod(0o700)


@pytest.mark.parametrize("format", Format)
def test_a_forbidden_folder_is_told_in_one_line(forbidden: Path, format: Format) -> None:
    with pytest.raises(OSError, match=rf"^\[Errno \d+\] .+: '{forbidden}/out'$"):
        write(forbidden / "out", format)
    assert not [name for name in os.listdir(forbidden) if "out" in name and "tmp" in name]
    assert not (forbidden / "out").exists()
