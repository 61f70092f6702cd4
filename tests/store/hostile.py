"""Takes agent files apart and puts them together again, changed."""

import hashlib
import io
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest

from ao2viz.store.errors import AgentFileError
from ao2viz.store.files import read


@dataclass
class Parts:
    manifest: dict[str, Any]
    members: dict[str, bytes]

    @classmethod
    def of(cls, path: Path) -> Self:
        with zipfile.ZipFile(path) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        return cls(json.loads(members.pop("manifest.json")), members)

    def array(self, name: str) -> np.ndarray:
        stored = np.load(io.BytesIO(self.members[name]), allow_pickle=False)
        return stored.astype(self.manifest["members"][name]["dtype"])

    def set_array(self, name: str, array: np.ndarray, **said: object) -> None:
        """Replaces an array; the manifest fits, but for what is `said` otherwise."""
        buffer = io.BytesIO()
        np.save(buffer, array)
        self.set_bytes(name, buffer.getvalue())
        self.manifest["members"][name] |= {
            "dtype": array.dtype.name,
            "stored": array.dtype.name,
            "shape": list(array.shape),
        } | said

    def set_bytes(self, name: str, content: bytes) -> None:
        self.members[name] = content
        entry = self.manifest["members"].setdefault(
            name, {"dtype": "int8", "stored": "int8", "shape": [1]}
        )
        entry["sha256"] = hashlib.sha256(content).hexdigest()

    def remove(self, name: str) -> None:
        del self.members[name]
        del self.manifest["members"][name]

    def write(self, path: Path, manifest: bytes | None = None) -> Path:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in self.members.items():
                archive.writestr(name, content)
            archive.writestr("manifest.json", manifest or json.dumps(self.manifest))
        return path


def refuse(path, words: str, opens=read) -> None:
    with pytest.raises(AgentFileError, match=words) as caught:
        opens(path)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 500
    assert message.isprintable()


def npy(array: np.ndarray, **settings) -> bytes:
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, array, **settings)
    return buffer.getvalue()
