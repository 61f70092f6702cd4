"""Manifests with fields that are missing, of the wrong kind, or beyond all bounds."""

import pytest

from ao2viz.store.files import read, summary
from tests.store.hostile import refuse


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("format", "something else", "manifest of an agent .* but its format is 'something else'"),
        ("format_version", 3, "needs a newer ao2viz: its format is 3, and 2 is the newest"),
        ("format_version", 0, "never been a format 0"),
        ("format_version", "1", "'format_version' in the manifest to be a whole number"),
        ("format_version", True, "'format_version' in the manifest to be a whole number"),
        ("seed", -1, "'seed' in the manifest to be a whole number"),
        ("seed", 1.5, "'seed' in the manifest to be a whole number"),
        ("preset", "clever", "'preset' in the manifest to be paper or anticipating"),
        ("preset", ["paper"], "'preset' in the manifest to be paper or anticipating"),
        ("preset", "paper", "A setting does not fit: There is no setting 'levels'"),
        ("created_at", "x" * 300, "'created_at' in the manifest to be at most 200 printable"),
        ("created_at", "\x1b[2Jgone", "'created_at' in the manifest to be at most 200 printable"),
        ("created_at", 5, "'created_at' in the manifest to be at most 200 printable"),
        ("versions", [], "'versions' in the manifest to be an object"),
        ("versions.numpy", 2, "'numpy' in the manifest to be at most 200 printable"),
        ("settings", None, "'settings' in the manifest to be an object"),
        ("settings.gamma", 7, "gamma between"),
        ("settings.gamma", "__import__('os')", "gamma to be a finite number"),
        ("settings.extra", 1, "no setting 'extra'"),
        ("settings.levels", 10**90, "'levels' in the settings"),
        ("settings.action_smoothing", 0.5, "A setting does not fit: .* actions are discrete"),
        ("settings.impression", -0.1, "impression between 0 and 1"),
        ("settings.max_depth", 1.5, "max_depth to be a whole number"),
        ("settings.credit", "x" * 5000, "'credit' in the settings"),
        ("task", [], "'task' in the manifest to be an object"),
        ("task.env_id", "os:path", "plain id, but got 'os:path'"),
        ("task.env_id", "a\nb", "'env_id' in the task to be at most 200 printable"),
        ("task.features", [], "at least one feature"),
        ("task.features", {}, "'features' in the task to be a list"),
        ("task.features", [5], "feature 0 to be an object"),
        ("task.features.0.scale", "wide", "'scale' in the feature 0 to be a finite number"),
        ("task.features.0.scale", 0, "scales other than 0"),
        ("task.features.0.range", -1.0, "positive ranges"),
        ("task.action_names", [], "at least one feature and one action"),
        ("task.action_names", ["a", 5], "'action_names' in the task to be at most 200"),
        ("task.action_names", ["a", "b", "c"], "'weights' of shape"),
        ("task.action_grid", [[1.0], [2.0, 3.0]], "one to three finite numbers"),
        ("task.action_grid", [[], []], "one to three finite numbers"),
        ("task.action_bins", 3, "no action_bins where actions are discrete"),
        ("task.action_offset", 2**60, "'action_offset' in the task"),
        ("generator.bit_generator", "MT19937", "'bit_generator' in the generator to be PCG64"),
        ("generator.state", "0xZZ", "'state' of the generator in hexadecimal"),
        ("generator.state", "0x" + "f" * 33, "'state' of the generator in hexadecimal"),
        ("generator.inc", 12, "'inc' in the generator to be at most"),
        ("generator.has_uint32", 2, "'has_uint32' in the generator"),
        ("generator.uinteger", 2**32, "'uinteger' in the generator"),
        ("n_options", 3, "Expected 3 options, but there are"),
        ("n_steps", None, "'n_steps' in the manifest to be a whole number"),
        ("mean_return", "good", "'mean_return' in the manifest to be a finite number"),
        ("growth_dropped", -1, "'growth_dropped' in the manifest"),
        ("episodes", {}, "'episodes' in the manifest to be a list"),
        ("episodes", [{}] * 1001, "'episodes' in the manifest to be a list of at most 1,000"),
        ("episodes.0", 7, "episode 0 to be an object"),
        ("episodes.0.steps", 10**9, "'observations' of a recorded episode"),
        ("episodes.0.steps", 0, "'steps' in the episode 0"),
        ("episodes.0.terminated", 1, "'terminated' in the episode 0 to be true or false"),
        ("members", [], "'members' in the manifest to be an object"),
        ("members.history.npy", 5, "for 'history.npy'"),
        ("members.history.npy.dtype", "object", "a known type, a shape and a checksum"),
        ("members.history.npy.stored", "int8", "a known type, a shape and a checksum"),
        ("members.history.npy.shape", [-1], "a known type, a shape and a checksum"),
        ("members.history.npy.shape", [1.0], "a known type, a shape and a checksum"),
        ("members.history.npy.shape", [1] * 20, "a known type, a shape and a checksum"),
        ("members.history.npy.sha256", "abc", "a known type, a shape and a checksum"),
    ],
)  # fmt: skip
def test_manifest_fields_that_cannot_be(parts, tmp_path, path, value, words):
    keys = path.replace("history.npy", "history_npy").split(".")
    keys = [int(k) if k.isdigit() else k.replace("history_npy", "history.npy") for k in keys]
    place = parts.manifest
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    refuse(parts.write(tmp_path / "a.ao2"), words)


def test_every_manifest_field_is_needed(parts, tmp_path):
    for holder in (parts.manifest, parts.manifest["task"], parts.manifest["generator"],
                   parts.manifest["settings"], parts.manifest["episodes"][0]):  # fmt: skip
        # An agent whose file says nothing of these did without.
        newer = {"think_ahead", "think_limit", "action_smoothing", "impression", "max_depth"}
        newer |= {"law_degree", "cleansing"}
        for name in sorted(holder.keys() - newer):
            value = holder.pop(name)
            refuse(parts.write(tmp_path / "a.ao2"), name if name != "format" else "None")
            holder[name] = value
    read(parts.write(tmp_path / "a.ao2"))


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"5", b"\xff\xfe", b'{"a": NaN}', b"null"])
def test_a_manifest_that_is_none(parts, tmp_path, content):
    path = parts.write(tmp_path / "a.ao2", manifest=content or b" ")
    refuse(path, "manifest")
    refuse(path, "manifest", opens=summary)


def test_settings_of_enormous_cost_are_bounded(parts, tmp_path):
    parts.manifest["settings"]["voters"] = 10**6
    refuse(parts.write(tmp_path / "a.ao2"), "voters between 2 and 64")
