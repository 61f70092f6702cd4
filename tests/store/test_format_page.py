"""docs/format.md names all that is in a file."""

import re
from pathlib import Path

import pytest

from ao2viz import AO2, GrowthKind, Preset
from ao2viz.store import archive, fields, manifest, saved
from tests.store.hostile import Parts

PAGE = (Path(__file__).parents[2] / "docs" / "format.md").read_text()
CODE = {part for text in re.findall(r"`([^`]+)`", PAGE) for part in re.split(r"[ ,]+", text)}


@pytest.mark.parametrize("preset", Preset)
def test_every_field_and_array_is_on_the_page(tmp_path, preset):
    agent = AO2("CartPole-v1", preset).learn(400)
    if preset is Preset.ANTICIPATING:
        agent.set_think_ahead(2)
    agent.record_episode(1)
    if preset is Preset.ANTICIPATING:
        assert agent.episodes[0].decisions[0].plan is not None
    agent.save(tmp_path / "a.ao2")
    parts = Parts.of(tmp_path / "a.ao2")
    top = parts.manifest
    fields = [*top, *top["task"], *top["task"]["features"][0], *top["generator"], *top["versions"]]
    fields += [*top["episodes"][0], *top["members"]["history.npy"]]
    assert [name for name in fields if name not in CODE] == []
    prefixes = ("learner/", "growth/", "episodes/0/")
    for name in parts.members:
        plain = name.removesuffix(".npy")
        for prefix in prefixes:
            plain = plain.removeprefix(prefix)
        assert plain in CODE or name in CODE, f"{name} is not on the page."


def test_the_page_tells_the_version_and_the_limits():
    assert f"`{manifest.FORMAT_VERSION}`" in PAGE
    assert f'"{manifest.FORMAT}"' in PAGE
    for limit in (archive.MAX_MEMBERS, manifest.MAX_EPISODES, saved.MAX_DEPTH, fields.MAX_TEXT):
        assert f"{limit:,} " in PAGE, limit
    limits = "512 MiB for the file, 1 GiB for all arrays in memory (512 MiB if it is uploaded"
    assert limits in " ".join(PAGE.split())
    assert (archive.MAX_FILE_BYTES, archive.MAX_ARRAY_BYTES) == (512 * 2**20, 2**30)
    assert archive.MAX_STRANGE_BYTES == 512 * 2**20
    assert archive.MAX_MANIFEST_BYTES == 8 * 2**20
    for kind in GrowthKind:
        assert f"{kind.value} {kind.name.lower()}" in PAGE
