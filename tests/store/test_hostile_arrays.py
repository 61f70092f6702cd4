"""Arrays that are none, that do not fit one another, or that no learner can have written."""

import numpy as np
import pytest

from ao2viz import AO2
from tests.store.hostile import npy, refuse


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
        ("episodes/0/decisions/n_voters", lambda a: changed(a, 99), "at most 1 voters"),
        ("episodes/0/decisions/n_voters", lambda a: changed(a, -1), "at most 1 voters"),
        ("episodes/0/decisions/path_length", lambda a: changed(a, 99), "paths of at most"),
        ("episodes/0/decisions/path_length", lambda a: changed(a, 0), "a path for every voter"),
        ("episodes/0/decisions/shares", lambda a: changed(a, np.nan), "finite shares"),
        ("episodes/0/decisions/shares", lambda a: changed(a, -1), "shares of at least 0"),
        ("episodes/0/decisions/created", lambda a: changed(a, 10**6), "created among"),
        ("episodes/0/decisions/voter_weights", lambda a: a[:, :, :1], "decisions/voter_weights'"),
        ("episodes/0/decisions/slopes", lambda a: changed(a, np.inf), "finite slopes"),
        ("episodes/0/decisions/slopes", lambda a: a[:, :, :1], "decisions/slopes'"),
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
