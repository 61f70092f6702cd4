"""Zips of plain arrays, read as if everyone wished us ill.

Rules: nothing is believed before it is checked, nothing is extracted to disk, every size is
bounded before memory is taken, and only the headers that we write ourselves are understood.
"""

import hashlib
import io
import math
import re
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import IO, Any, Self

import numpy as np
from numpy.typing import NDArray

from ao2viz.store.errors import AgentFileError, quote

MANIFEST = "manifest.json"
MAX_FILE_BYTES = 512 * 2**20
MAX_ARRAY_BYTES = 2**30
"""All arrays of one file together, as they are in memory: room for a million options."""
MAX_STRANGE_BYTES = 512 * 2**20
"""The same, of a file that somebody uploads."""
MAX_MANIFEST_BYTES = 8 * 2**20
MAX_MEMBERS = 30_000

_NAME = re.compile(
    r"(history|learner/[a-z0-9_]{1,60}|growth/[a-z_]{1,20}|"
    r"episodes/[0-9]{1,5}/([a-z_]{1,20}|decisions/[a-z_]{1,30}))\.npy"
)
_DTYPES = {"bool": "|b1", "int8": "|i1", "int16": "<i2", "int32": "<i4", "int64": "<i8",
           "float32": "<f4", "float64": "<f8"}  # fmt: skip
_NARROWER = {
    "int64": ("int8", "int16", "int32"),
    "int32": ("int8", "int16"),
    "float64": ("float32",),
}
_HEADER = re.compile(
    rb"\{'descr': '([|<][a-z][0-9])', 'fortran_order': False, 'shape': \(([0-9, ]{0,80})\), \} *\n"
)
_MAX_DIMENSION = 2**40
_END_OF_ZIP = struct.Struct("<4s4H2LH")
_CHUNK = 2**20
# Everything zipfile and zlib are known to raise on broken input; a KeyError is a missing member.
_BROKEN = (zipfile.BadZipFile, OSError, EOFError, ValueError, KeyError, NotImplementedError,
           RuntimeError, struct.error, OverflowError, zlib.error)  # fmt: skip


@dataclass(frozen=True)
class Member:
    """What the manifest says of one array."""

    dtype: str  # In memory, a key of `_DTYPES`.
    stored: str  # In the file: the same, or a narrower type that keeps every value exactly.
    shape: tuple[int, ...]
    sha256: str  # Of the .npy bytes.

    def to_json(self) -> dict[str, Any]:
        """Plain values for the manifest."""
        return {
            "dtype": self.dtype,
            "stored": self.stored,
            "shape": list(self.shape),
            "sha256": self.sha256,
        }

    @classmethod
    def from_json(cls, name: str, raw: Any) -> "Member":
        """Reads a manifest's entry.

        Raises:
            AgentFileError: If it is not what `to_json` writes.
        """
        keys = {"dtype", "stored", "shape", "sha256"}
        if not (isinstance(raw, dict) and raw.keys() == keys):
            raise AgentFileError(f"Expected {', '.join(sorted(keys))} for {quote(name)}.")
        dtype, stored, shape, digest = raw["dtype"], raw["stored"], raw["shape"], raw["sha256"]
        sound = (
            isinstance(dtype, str)
            and dtype in _DTYPES
            and (stored == dtype or stored in _NARROWER.get(dtype, ()))
            and isinstance(shape, list)
            and len(shape) <= 6
            and all(type(n) is int and 0 <= n <= _MAX_DIMENSION for n in shape)
            and isinstance(digest, str)
            and re.fullmatch("[0-9a-f]{64}", digest)
        )
        if not sound:
            raise AgentFileError(
                f"Expected a known type, a shape and a checksum for {quote(name)}, but the "
                f"manifest says {quote(raw)}."
            )
        return cls(dtype, stored, tuple(shape), digest)

    @property
    def n_bytes(self) -> int:
        """What the array takes in memory; a length of 0 counts as 1, to bound every length."""
        return math.prod(max(n, 1) for n in self.shape) * np.dtype(self.dtype).itemsize


class ArchiveWriter:
    """Writes arrays into a zip, the manifest last."""

    def __init__(self, stream: IO[bytes]) -> None:
        self.members: dict[str, Member] = {}
        self._zip = zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=6)

    def add(self, name: str, array: NDArray) -> None:
        """Writes one array, in the narrowest type that keeps every value exactly.

        Raises:
            ValueError: If the name or the type is not one that `ArchiveReader` takes.
        """
        dtype = array.dtype.name
        if not _NAME.fullmatch(name) or dtype not in _DTYPES:
            raise ValueError(f"Expected a plain array with a plain name, not {name!r} of {dtype}.")
        narrow = _narrow(array)
        buffer = io.BytesIO()
        header = {"descr": _DTYPES[narrow.dtype.name], "fortran_order": False, "shape": array.shape}
        np.lib.format.write_array_header_1_0(buffer, header)
        buffer.write(np.ascontiguousarray(narrow).tobytes())
        content = buffer.getvalue()
        digest = hashlib.sha256(content).hexdigest()
        self.members[name] = Member(dtype, narrow.dtype.name, array.shape, digest)
        self._write(name, content)

    def finish(self, manifest: bytes) -> None:
        """Writes the manifest and the zip's directory."""
        self._write(MANIFEST, manifest)
        self._zip.close()

    def _write(self, name: str, content: bytes) -> None:
        # The zip's own fixed first date: the same agent gives the same bytes.
        info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
        info.compress_type = zipfile.ZIP_DEFLATED
        info.external_attr = 0o644 << 16
        self._zip.writestr(info, content)


class ArchiveReader:
    """Reads what `ArchiveWriter` wrote; every failure is an `AgentFileError`."""

    def __init__(self, stream: IO[bytes], most: int = MAX_ARRAY_BYTES) -> None:
        """Opens an archive whose arrays need at most so many bytes of memory."""
        self._most = most
        _check_directory(stream)
        try:
            self._zip = zipfile.ZipFile(stream)
            infos = self._zip.infolist()
        except _BROKEN as error:
            raise AgentFileError(f"Expected a whole zip file, but: {_reason(error)}.") from error
        self._infos = {info.filename: info for info in infos}
        if len(self._infos) != len(infos):
            raise AgentFileError("Expected every name once, but the file holds some twice.")
        for info in infos:
            _check_info(info)
        if MANIFEST not in self._infos:
            raise AgentFileError(f"Expected a {MANIFEST} inside, but there is none.")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._zip.close()

    def read_manifest(self) -> bytes:
        """The manifest, undecoded."""
        info = self._infos[MANIFEST]
        try:
            with self._zip.open(info) as stream:
                content = stream.read(MAX_MANIFEST_BYTES + 1)
        except _BROKEN as error:
            raise AgentFileError(f"The {MANIFEST} is damaged: {_reason(error)}.") from error
        if len(content) > MAX_MANIFEST_BYTES:
            raise AgentFileError(f"Expected a {MANIFEST} of at most {MAX_MANIFEST_BYTES} bytes.")
        return content

    def read_arrays(self, members: Mapping[str, Member]) -> dict[str, NDArray]:
        """Every array, its checksum compared; read-only.

        Raises:
            AgentFileError: If file and manifest differ in anything, or it is too much to read.
        """
        there = self._infos.keys() - {MANIFEST}
        if there != members.keys():
            lacking = sorted(members.keys() - there) or ["nothing"]
            extra = sorted(there - members.keys()) or ["nothing"]
            raise AgentFileError(
                f"Expected the arrays that the manifest names; missing: {quote(lacking[0])}, not "
                f"named: {quote(extra[0])}."
            )
        total = sum(member.n_bytes for member in members.values())
        if total > self._most:
            raise AgentFileError(
                f"Expected arrays of at most {self._most:,} bytes in all, but these need {total:,}."
            )
        return {name: self._read_array(name, member) for name, member in members.items()}

    def _read_array(self, name: str, member: Member) -> NDArray:
        try:
            with self._zip.open(self._infos[name]) as stream:
                array, digest = _read_npy(stream, name, member, self._infos[name].file_size)
        except AgentFileError:
            raise
        except _BROKEN as error:
            raise AgentFileError(f"{quote(name)} is damaged: {_reason(error)}.") from error
        if digest != member.sha256:
            raise AgentFileError(f"{quote(name)} is damaged: its checksum differs.")
        if member.dtype == "bool" and (array.view(np.uint8) > 1).any():
            raise AgentFileError(f"Expected only 0 and 1 in {quote(name)}.")
        array = array.astype(member.dtype, copy=False)
        array.flags.writeable = False
        return array


def _narrow(array: NDArray) -> NDArray:
    for name in _NARROWER.get(array.dtype.name, ()):
        if array.dtype.kind == "i":
            limits = np.iinfo(name)
            if array.size and (array.min() < limits.min or array.max() > limits.max):
                continue
            return array.astype(name)
        with np.errstate(over="ignore", invalid="ignore"):
            narrow = array.astype(name)
        # Compared as bits, so that NaN and -0 count too.
        if np.array_equal(
            np.ascontiguousarray(narrow.astype(array.dtype)).view(np.int64),
            np.ascontiguousarray(array).view(np.int64),
        ):
            return narrow
    return array


def _check_directory(stream: IO[bytes]) -> None:
    """Bounds what `zipfile` is about to read; it would take a directory of any size."""
    size = stream.seek(0, io.SEEK_END)
    if not _END_OF_ZIP.size <= size <= MAX_FILE_BYTES:
        raise AgentFileError(
            f"Expected a zip file of at most {MAX_FILE_BYTES:,} bytes, but it has {size:,}."
        )
    stream.seek(max(0, size - _END_OF_ZIP.size - 20))
    tail = stream.read()
    end = tail[-_END_OF_ZIP.size :]
    magic, _, _, _, entries, directory_size, _, comment = _END_OF_ZIP.unpack(end)
    # A zip64 locator in front would overrule the numbers just read.
    is_zip64 = tail[: -_END_OF_ZIP.size].startswith(b"PK\x06\x07")
    if magic != b"PK\x05\x06" or comment or is_zip64:
        raise AgentFileError("Expected a plain zip file, but this one is cut short or none.")
    if entries > MAX_MEMBERS or directory_size > MAX_MEMBERS * 200:
        raise AgentFileError(f"Expected at most {MAX_MEMBERS:,} members in the file.")


def _check_info(info: zipfile.ZipInfo) -> None:
    if info.filename != MANIFEST and not _NAME.fullmatch(info.filename):
        raise AgentFileError(f"Expected no member called {quote(info.filename)} in an agent file.")
    limit = MAX_MANIFEST_BYTES if info.filename == MANIFEST else MAX_ARRAY_BYTES
    if info.file_size > limit or info.compress_size > MAX_FILE_BYTES:
        raise AgentFileError(
            f"Expected {quote(info.filename)} to have at most {limit:,} bytes, but it declares "
            f"{info.file_size:,}."
        )
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or info.flag_bits & 1:
        raise AgentFileError(f"Expected {quote(info.filename)} plainly deflated.")


def _read_npy(stream: IO[bytes], name: str, member: Member, size: int) -> tuple[NDArray, str]:
    """An array and the checksum of its bytes; takes memory only for what was announced."""
    start = stream.read(10)
    if len(start) != 10 or start[:8] != b"\x93NUMPY\x01\x00":
        raise AgentFileError(f"Expected {quote(name)} to be a .npy array of version 1.0.")
    header = stream.read(int.from_bytes(start[8:], "little"))
    match = _HEADER.fullmatch(header)
    lengths = tuple(int(n) for n in match[2].decode().split(",") if n.strip()) if match else ()
    if not match or match[1].decode() != _DTYPES[member.stored] or lengths != member.shape:
        raise AgentFileError(
            f"Expected {quote(name)} to be {member.stored} of shape {member.shape}, but its header "
            f"says {quote(header[:200])}."
        )
    n_bytes = math.prod(member.shape) * np.dtype(member.stored).itemsize
    if size != len(start) + len(header) + n_bytes:
        raise AgentFileError(f"Expected {n_bytes:,} bytes of numbers in {quote(name)}.")
    digest = hashlib.sha256(start + header)
    content = bytearray(n_bytes)
    view = memoryview(content)
    filled = 0
    while filled < n_bytes:
        chunk = stream.read(min(_CHUNK, n_bytes - filled))
        if not chunk:
            raise AgentFileError(f"{quote(name)} is cut short.")
        view[filled : filled + len(chunk)] = chunk
        digest.update(chunk)
        filled += len(chunk)
    if stream.read(1):  # Reaching the end also makes zipfile compare its own checksum.
        raise AgentFileError(f"{quote(name)} holds more than it announced.")
    array = np.frombuffer(content, _DTYPES[member.stored]).reshape(member.shape)
    return array, digest.hexdigest()


def _reason(error: BaseException) -> str:
    return quote(str(error) or type(error).__name__)
