"""Whatever is wrong with a file becomes one clear line, and nothing else happens."""

import io
import struct
import tracemalloc
import zipfile

import numpy as np
import pytest

from ao2viz import AO2
from ao2viz.store.errors import AgentFileError
from ao2viz.store.files import read, summary


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
    assert peak_megabytes(path, "at most 536,870,912 bytes, but it declares") < 20


@pytest.mark.parametrize("shape", [[2**30, 2**30], [2**40], [10**9], [0, 2**40], [2**31, 0, 2**31]])
def test_shapes_beyond_memory(parts, tmp_path, shape):
    parts.manifest["members"]["learner/weights.npy"]["shape"] = shape
    path = parts.write(tmp_path / "a.ao2")
    assert peak_megabytes(path, "536,870,912 bytes in all") < 20


def test_narrow_arrays_that_widen_beyond_memory(parts, tmp_path):
    shape = [2**27]
    parts.manifest["members"]["learner/weights.npy"] |= {
        "dtype": "int64", "stored": "int8", "shape": shape,
    }  # fmt: skip
    path = parts.write(tmp_path / "a.ao2")
    assert peak_megabytes(path, "536,870,912 bytes in all") < 20


def test_a_directory_beyond_memory(tmp_path):
    path = tmp_path / "a.ao2"
    with zipfile.ZipFile(path, "w") as archive:
        for n in range(30_000):
            archive.writestr(f"learner/a{n}.npy", b"")
    assert peak_megabytes(path, "at most 20,000 members") < 5


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


# Arrays.


def test_pickled_arrays(parts, tmp_path):
    class Harm:
        def __reduce__(self):
            return (pytest.fail, ("A file ran code.",))

    content = npy(np.array([Harm()], object), allow_pickle=True)
    parts.set_bytes("learner/weights.npy", content)
    refuse(parts.write(tmp_path / "a.ao2"), "its header says")


@pytest.mark.parametrize(
    "content",
    [b"", b"\x93NUMPY", b"\x93NUMPY\x02\x00" + b" " * 90, b"\x93NUMPY\x01\x00\xff\xff{",
     b"\x93NUMPY\x01\x00\x40\x00{'descr': __import__('os'), 'shape': ()}" + b" " * 30],
)  # fmt: skip
def test_arrays_that_are_none(parts, tmp_path, content):
    parts.set_bytes("learner/weights.npy", content)
    refuse(parts.write(tmp_path / "a.ao2"), r"learner/weights.npy'")


@pytest.mark.parametrize(
    "array",
    [np.zeros((3, 2), "<U1"), np.zeros(3, complex), np.zeros(3, ">f8"), np.zeros(3, "M8[s]"),
     np.zeros(3, [("a", "<f8")]), np.asfortranarray(np.zeros((4, 2)))],
)  # fmt: skip
def test_types_that_are_never_written(parts, tmp_path, array):
    parts.set_bytes("learner/weights.npy", npy(array))
    refuse(parts.write(tmp_path / "a.ao2"), "its header says")


def test_more_or_less_bytes_than_the_shape_needs(parts, tmp_path):
    content = parts.members["learner/weights.npy"]
    for changed in (content + b"x", content[:-1]):
        parts.set_bytes("learner/weights.npy", changed)
        refuse(parts.write(tmp_path / "a.ao2"), "bytes of numbers")


def test_truths_that_are_neither(parts, tmp_path):
    content = bytearray(parts.members["learner/is_alive.npy"])
    content[-1] = 7
    parts.set_bytes("learner/is_alive.npy", bytes(content))
    refuse(parts.write(tmp_path / "a.ao2"), "only 0 and 1")


def changed(array: np.ndarray, value: float, index=0) -> np.ndarray:
    array = array.copy()
    array[index] = value
    return array


def swapped(parents: np.ndarray, one: int, other: int) -> np.ndarray:
    """Two options that are each other's parents."""
    return changed(changed(parents, one, other), other, one)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("learner/weights", lambda a: changed(a, np.nan), "finite numbers in 'weights'"),
        ("learner/values", lambda a: changed(a, np.inf), "finite numbers in 'values'"),
        ("learner/attention", lambda a: changed(a, np.nan), "finite numbers in 'attention'"),
        ("learner/values", lambda a: a[:-1], "'parents' of shape"),
        ("learner/values", lambda a: a[:, :-1], "'values' of shape"),
        ("learner/values", lambda a: a.astype(np.float32), "type float64, but it has"),
        ("learner/values", lambda a: a.reshape(-1), "of shape"),
        ("learner/weights", lambda a: a[:, :1], "'weights' of shape"),
        ("learner/visits", lambda a: changed(a, -1), "visits .* at least 0"),
        ("learner/born", lambda a: changed(a, -1), "birth steps of at least 0"),
        ("learner/parents", lambda a: changed(a, len(a)), "parents and links among"),
        ("learner/parents", lambda a: changed(a, -2), "parents and links among"),
        ("learner/parents", lambda a: swapped(a, 2, 3), "deeper or lead in a circle"),
        ("learner/parents", lambda a: changed(a, 5, 5), "deeper or lead in a circle"),
        ("learner/is_alive", lambda a: changed(a, False), "living option"),
        ("learner/links", lambda a: np.array([[0, 10**6]], np.int32), "parents and links among"),
        ("learner/revision", lambda a: np.zeros(2, np.int64), "'revision' of shape"),
        ("history", lambda a: a[:, :3], "history as float64 with four columns"),
        ("history", lambda a: changed(a, np.nan), "finite numbers in the training history"),
        ("history", lambda a: a.astype(np.int64), "history as float64 with four columns"),
        ("growth/kind", lambda a: changed(a, 99), "growth events of known kinds"),
        ("growth/step", lambda a: a[:-1], "growth log to be equally long"),
        ("growth/step", lambda a: a[::-1], "order of their steps"),
        ("growth/option", lambda a: a.astype(np.int64), "growth log as"),
        ("episodes/0/actions", lambda a: changed(a, 2), "actions below 2"),
        ("episodes/0/rewards", lambda a: changed(a, np.inf), "finite observations"),
        ("episodes/0/observations", lambda a: a[:-1], "'observations' of a recorded episode"),
        ("episodes/0/decisions/voters", lambda a: changed(a, 10**6), "voters among the options"),
        ("episodes/0/decisions/voters", lambda a: changed(a, -1), "an option for every voter"),
        ("episodes/0/decisions/paths", lambda a: changed(a, 10**6), "paths among the options"),
        ("episodes/0/decisions/paths", lambda a: changed(a, -1), "a path for every voter"),
        ("episodes/0/decisions/paths", lambda a: a[:, :, :0], "path_distances' of a recorded"),
        ("episodes/0/decisions/n_voters", lambda a: changed(a, 99), "at most 16 voters"),
        ("episodes/0/decisions/n_voters", lambda a: changed(a, -1), "at most 16 voters"),
        ("episodes/0/decisions/path_length", lambda a: changed(a, 99), "paths of at most"),
        ("episodes/0/decisions/path_length", lambda a: changed(a, 0), "a path for every voter"),
        ("episodes/0/decisions/shares", lambda a: changed(a, np.nan), "finite shares"),
        ("episodes/0/decisions/shares", lambda a: changed(a, -1), "shares of at least 0"),
        ("episodes/0/decisions/created", lambda a: changed(a, 10**6), "created among"),
        ("episodes/0/decisions/voter_weights", lambda a: a[:, :, :1], "decisions/voter_weights'"),
    ],
)  # fmt: skip
def test_arrays_that_do_not_fit_one_another(parts, tmp_path, name, change, words):
    array = parts.array(f"{name}.npy")
    parts.set_array(f"{name}.npy", np.ascontiguousarray(change(array)))
    refuse(parts.write(tmp_path / "a.ao2"), words)


@pytest.mark.parametrize(
    "name",
    ["learner/values", "learner/counters", "learner/experience_reward", "history", "growth/kind",
     "episodes/0/rewards", "episodes/1/decisions/paths"],
)  # fmt: skip
def test_a_missing_array(parts, tmp_path, name):
    parts.remove(f"{name}.npy")
    refuse(parts.write(tmp_path / "a.ao2"), "Expected", opens=AO2.load)


def test_an_array_too_many_in_an_episode(parts, tmp_path):
    parts.set_array("episodes/0/extra.npy", np.zeros(1))
    refuse(parts.write(tmp_path / "a.ao2"), "only the known arrays")


def test_an_episode_too_many(parts, tmp_path):
    parts.set_array("episodes/7/rewards.npy", np.zeros(1))
    refuse(parts.write(tmp_path / "a.ao2"), "exactly the recorded episodes")


def test_a_chain_so_deep_that_searching_it_would_never_end(parts, tmp_path):
    n = 300_000
    for name, array in {
        "values": np.zeros((n, 4)), "parents": np.arange(-1, n - 1, dtype=np.int32),
        "is_alive": np.ones(n, bool), "born": np.zeros(n, np.int64), "weights": np.zeros((n, 2)),
        "visits": np.zeros((n, 2), np.int32),
    }.items():  # fmt: skip
        parts.set_array(f"learner/{name}.npy", array)
    refuse(parts.write(tmp_path / "a.ao2"), "at most 10,000 deep")


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("learner/counters", lambda a: changed(a, 0, 1), "not sound"),
        ("learner/counters", lambda a: changed(a, -5, 1), "not sound"),
        ("learner/counters", lambda a: changed(a, -1, 0), "600 steps, but it has -1"),
        ("learner/counters", lambda a: changed(a, 601, 0), "600 steps"),
        ("learner/imagination_end_ids", lambda a: changed(a, 10**6), "not sound"),
        ("learner/imagination_story_end", lambda a: changed(a, 10**6), "not sound"),
        ("learner/experience_reward", lambda a: a[:-1], "not sound"),
        ("learner/spread", lambda a: a[:1], "not sound"),
        ("learner/waiting", lambda a: np.full((1, 12), 1e9), "not sound"),
        ("learner/links", lambda a: np.repeat(a[:1], 2, axis=0), "every link once"),
    ],
)
def test_what_was_learned_must_be_sound_as_well(parts, tmp_path, name, change, words):
    array = np.ascontiguousarray(change(parts.array(f"{name}.npy")))
    parts.set_array(f"{name}.npy", array)
    refuse(parts.write(tmp_path / "a.ao2"), words, opens=AO2.load)


# The manifest.


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("format", "something else", "manifest of an agent .* but its format is 'something else'"),
        ("format_version", 2, "needs a newer ao2viz: its format is 2, and 1 is the newest"),
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
        for name in list(holder):
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
    refuse(parts.write(tmp_path / "a.ao2"), "voters between 1 and 64")
