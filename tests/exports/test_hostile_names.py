"""Names that want to do harm come back as they were, and do none, in every format."""

import json
from pathlib import Path

import jsonschema
import minari
import pyarrow.parquet as pq
import pytest
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

import ao2viz
from ao2viz import AO2, Format
from ao2viz.exports.formats import ABOUT
from tests.exports.agents import (
    UNPRINTABLE,
    WORST,
    WORST_ACTIONS,
    brief,
    unprintable,
    worst,
)
from tests.exports.conftest import Export
from tests.exports.test_all_or_nothing import content_of
from tests.exports.test_tables import SCHEMA

TEXTS = {about.suffix for about in ABOUT.values()} - {
    *(".parquet", ".png", ".mp4", ".gif", "")  # In whose bytes any sign can stand.
}
PLAIN = "".join(c if c.isprintable() else " " for c in UNPRINTABLE)


@pytest.fixture
def worst_file(tmp_path: Path) -> Path:
    """The names as they come: in a file of a stranger."""
    path = tmp_path / "stranger.ao2"
    AO2.from_saved(worst()).save(path)
    return path


def test_json_gives_them_back(worst_file: Path, write: Export) -> None:
    document = json.loads(write(worst_file, "json").read_text("utf-8"))
    jsonschema.validate(document, SCHEMA, jsonschema.Draft202012Validator)
    assert tuple(feature["name"] for feature in document["features"]) == WORST
    assert {feature["unit"] for feature in document["features"]} == {WORST[0]}
    assert tuple(action["name"] for action in document["actions"]) == WORST_ACTIONS
    assert document["agent"]["title"] == WORST[3]
    for step in document["episodes"][0]["steps"]:
        assert step["headline"] == WORST_ACTIONS[step["decision"]["action"]]
        assert any(name in step["reason"] for name in WORST)
    told = json.loads(write(worst_file, "option-json", option=0).read_text("utf-8"))
    assert tuple(feature["name"] for feature in told["features"]) == WORST
    assert tuple(told["actions"]) == WORST_ACTIONS


def test_parquet_gives_them_back(worst_file: Path, write: Export) -> None:
    table = pq.read_table(write(worst_file, "parquet"))
    names = json.loads(table.schema.metadata[b"ao2viz"])
    assert tuple(names["features"]) == WORST
    assert tuple(names["actions"]) == WORST_ACTIONS
    rows = table.to_pylist()
    assert len(rows) == 5
    for row in rows:
        assert row["action_name"] == WORST_ACTIONS[row["action"]]
        assert any(name in row["reason"] for name in WORST)


def test_scalars_have_the_tags_and_numbers_of_any_agent(
    worst_file: Path, tmp_path: Path, write: Export
) -> None:
    folders = (
        write(worst_file, "tensorboard"),
        ao2viz.export(brief(), tmp_path / "friendly", "tensorboard"),
    )
    one, other = (EventAccumulator(str(f), {"scalars": 0}).Reload() for f in folders)
    tags = one.Tags()["scalars"]
    assert tags == other.Tags()["scalars"]
    assert all(tag.replace("/", "").replace("_", "").isalnum() for tag in tags)
    for tag in tags:
        assert one.Scalars(tag) == other.Scalars(tag)
    assert content_of(folders[0]) == content_of(folders[1])


def test_a_data_set_is_called_and_holds_what_that_of_any_agent_does(
    worst_file: Path, write: Export, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write(worst_file, "minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(folder))
    (name,) = minari.list_local_datasets()
    assert name == "cartpole-v1/ao2viz-v0"
    dataset = minari.load_dataset(name)
    (read,) = dataset
    (episode,) = brief().episodes
    assert read.observations.tolist() == episode.observations.tolist()
    assert read.actions.tolist() == episode.actions.tolist()
    assert not any(word in str(dataset.storage.metadata) for word in ("window", "cmd"))
    assert not any(b"window.ran" in part for part in content_of(folder).values())


@pytest.mark.parametrize("format", [f for f in Format if ABOUT[f].suffix in TEXTS])
def test_what_no_file_could_hold_is_in_no_text(write: Export, format: Format) -> None:
    text = write(unprintable(), format.value, option=0).read_text("utf-8-sig")
    assert not {c for c in UNPRINTABLE if not c.isprintable() and c not in "\n\r\t"} & set(text)


def test_unprintable_characters_are_spaces_in_data(write: Export) -> None:
    document = json.loads(write(unprintable(), "json").read_text("utf-8"))
    assert document["agent"]["title"] == PLAIN
    assert [action["name"] for action in document["actions"]] == [f"0{PLAIN}", f"1{PLAIN}"]
    table = pq.read_table(write(unprintable(), "parquet"))
    assert json.loads(table.schema.metadata[b"ao2viz"])["features"][3] == f"3{PLAIN}"
    assert set(table["action_name"].to_pylist()) <= {f"0{PLAIN}", f"1{PLAIN}"}
