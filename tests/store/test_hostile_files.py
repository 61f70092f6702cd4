"""Broken zips, names that lead elsewhere, sizes beyond memory: one clear line, nothing else."""

import struct
import tracemalloc
import zipfile

import numpy as np
import pytest

from ao2viz.store.errors import AgentFileError
from ao2viz.store.files import read
from tests.store.hostile import npy, refuse

# Broken files.


@pytest.mark.parametrize("content", [b"", b"PK", b"nonsense " * 100, b"\x80\x04K\x01."])
def test_not_a_zip(tmp_path, content):
    (tmp_path / "a.ao2").write_bytes(content)
    refuse(tmp_path / "a.ao2", "zip file")


def test_missing_files_and_folders(tmp_path):
    refuse(tmp_path / "no.ao2", "There is no file '.*no.ao2'")
    refuse(tmp_path, "Could not read '.*': Is a directory")


@pytest.mark.parametrize("part", np.linspace(0.02, 0.9995, 25).tolist())
def test_truncated(tmp_path, file, part):
    content = file.read_bytes()
    (tmp_path / "a.ao2").write_bytes(content[: int(part * len(content))])
    refuse(tmp_path / "a.ao2", "cut short")


def test_a_flipped_bit_is_noticed_or_harmless(tmp_path, file):
    content, path = file.read_bytes(), tmp_path / "a.ao2"
    right = read(file)
    noticed = 0
    for position in np.random.default_rng(0).integers(len(content) * 8, size=400).tolist():
        flipped = bytearray(content)
        flipped[position // 8] ^= 1 << position % 8
        path.write_bytes(flipped)
        try:
            came = read(path)
        except AgentFileError:
            noticed += 1
            continue
        # Dates and other things nobody reads: what is read must be what was written.
        assert came.state.keys() == right.state.keys()
        assert all(
            np.array_equal(came.state[n], right.state[n], equal_nan=True) for n in right.state
        )
        assert (came.config, came.seed) == (right.config, right.seed)
    assert noticed > 350


def test_a_changed_array_with_a_right_zip_is_caught_by_our_checksum(parts, tmp_path):
    content = bytearray(parts.members["learner/weights.npy"])
    content[-1] ^= 1
    parts.members["learner/weights.npy"] = bytes(content)
    refuse(parts.write(tmp_path / "a.ao2"), r"learner/weights.npy' is damaged: its checksum")


# Names.


@pytest.mark.parametrize(
    "name",
    ["../../etc/passwd", "/etc/passwd", "learner/../../x.npy", "learner/x.pkl", "C:\\x.npy",
     "learner/values.npy\n", "episodes/0/decisions/../x.npy", "learner/", "x" * 3000],
)  # fmt: skip
def test_names_that_lead_elsewhere(parts, tmp_path, name):
    parts.set_bytes(name, b"x")
    refuse(parts.write(tmp_path / "a.ao2"), "no member called|cut short|whole zip")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.ao2"]


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_name_twice(parts, tmp_path):
    path = parts.write(tmp_path / "a.ao2")
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("learner/weights.npy", parts.members["learner/weights.npy"])
    refuse(path, "every name once")


def test_arrays_that_are_missing_or_not_named(parts, tmp_path):
    content = parts.members.pop("learner/weights.npy")
    refuse(parts.write(tmp_path / "a.ao2"), "missing: 'learner/weights.npy'")
    parts.members["learner/weights.npy"] = content
    del parts.manifest["members"]["learner/weights.npy"]
    refuse(parts.write(tmp_path / "a.ao2"), "not named: 'learner/weights.npy'")


def test_no_manifest(parts, tmp_path):
    path = tmp_path / "a.ao2"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("history.npy", parts.members["history.npy"])
    refuse(path, "manifest.json inside")


# Sizes.


def peak_megabytes(path, words: str) -> float:
    tracemalloc.start()
    refuse(path, words)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 2**20


def bomb(path, name: str, content: bytes, declared: int) -> None:
    """A zip with one more member that says it is `declared` bytes long."""
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
        info = archive.getinfo(name)
    raw = bytearray(path.read_bytes())
    for magic, offset in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        start = raw.rindex(magic, 0, raw.rindex(name.encode()) if offset == 24 else len(raw))
        if offset == 22:
            start = info.header_offset
        assert struct.unpack_from("<L", raw, start + offset)[0] == len(content)
        struct.pack_into("<L", raw, start + offset, declared)
    path.write_bytes(raw)


def test_a_bomb_that_says_it_is_small(parts, tmp_path):
    path = tmp_path / "a.ao2"
    parts.manifest["members"]["learner/bomb.npy"] = {
        "dtype": "int8", "stored": "int8", "shape": [64], "sha256": "0" * 64,
    }  # fmt: skip
    content = npy(np.zeros(2**27, np.int8))
    parts.write(path)
    bomb(path, "learner/bomb.npy", content, declared=192)
    assert path.stat().st_size < 2**20
    assert peak_megabytes(path, "learner/bomb.npy") < 20


def test_a_bomb_that_says_how_big_it_is(parts, tmp_path):
    path = tmp_path / "a.ao2"
    parts.write(path)
    bomb(path, "learner/bomb.npy", bytes(2**20), declared=2**31)
    assert peak_megabytes(path, "at most 1,073,741,824 bytes, but it declares") < 20


@pytest.mark.parametrize("shape", [[2**30, 2**30], [2**40], [10**9], [0, 2**40], [2**31, 0, 2**31]])
def test_shapes_beyond_memory(parts, tmp_path, shape):
    parts.manifest["members"]["learner/weights.npy"]["shape"] = shape
    path = parts.write(tmp_path / "a.ao2")
    assert peak_megabytes(path, "1,073,741,824 bytes in all") < 20


def test_narrow_arrays_that_widen_beyond_memory(parts, tmp_path):
    shape = [2**27]
    parts.manifest["members"]["learner/weights.npy"] |= {
        "dtype": "int64", "stored": "int8", "shape": shape,
    }  # fmt: skip
    path = parts.write(tmp_path / "a.ao2")
    assert peak_megabytes(path, "1,073,741,824 bytes in all") < 20


def test_a_directory_beyond_memory(tmp_path):
    path = tmp_path / "a.ao2"
    with zipfile.ZipFile(path, "w") as archive:
        for n in range(31_000):
            archive.writestr(f"learner/a{n}.npy", b"")
    assert peak_megabytes(path, "at most 30,000 members") < 5


def test_a_directory_whose_size_is_overruled(tmp_path, file):
    content = file.read_bytes()
    end = content[-22:]
    record = struct.pack("<4sQ2H2L4Q", b"PK\x06\x06", 44, 45, 45, 0, 0, 9, 9, 2**40, 0)
    locator = struct.pack("<4sLQL", b"PK\x06\x07", 0, len(content) - 22, 1)
    path = tmp_path / "a.ao2"
    path.write_bytes(content[:-22] + record + locator + end)
    refuse(path, "plain zip file")


def test_a_manifest_beyond_memory(parts, tmp_path):
    path = parts.write(tmp_path / "a.ao2", manifest=b" " * (9 * 2**20))
    assert peak_megabytes(path, "manifest.json' to have at most") < 20


def test_nesting_beyond_the_stack(parts, tmp_path):
    refuse(parts.write(tmp_path / "a.ao2", manifest=b"[" * 200_000), "manifest in JSON")


def test_numbers_with_too_many_digits(parts, tmp_path):
    manifest = b'{"format": "ao2viz-agent", "format_version": ' + b"9" * 10_000 + b"}"
    refuse(parts.write(tmp_path / "a.ao2", manifest=manifest), "manifest in JSON")
