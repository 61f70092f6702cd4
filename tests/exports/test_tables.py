"""What programs read: JSON by its schema, CSV and Parquet by other people's readers."""

import csv
import json

import jsonschema
import numpy as np
import pyarrow.parquet as pq
import pytest

from ao2viz.resources import static
from ao2viz.store.saved import SavedAgent
from tests.exports.agents import HOSTILE_TITLE
from tests.exports.conftest import Export

SCHEMA = json.loads((static() / "export.schema.json").read_text("utf-8"))
AGENTS = ("cartpole", "pendulum", "hostile")


@pytest.fixture(params=AGENTS)
def agent(request: pytest.FixtureRequest) -> SavedAgent:
    return request.getfixturevalue(request.param)


def test_json_is_what_its_schema_says(agent: SavedAgent, write: Export) -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    document = json.loads(write(agent, "json").read_text("utf-8"))
    jsonschema.validate(document, SCHEMA, jsonschema.Draft202012Validator)


def test_the_schema_refuses_what_it_does_not_know(cartpole: SavedAgent, write: Export) -> None:
    document = json.loads(write(cartpole, "json").read_text("utf-8"))
    for broken in (document | {"version": 2}, document | {"more": 1}):
        with pytest.raises(jsonschema.ValidationError, match=r"1 was expected|more"):
            jsonschema.validate(broken, SCHEMA)
    del document["episodes"][0]["steps"][3]["decision"]["margin"]
    with pytest.raises(jsonschema.ValidationError, match="margin"):
        jsonschema.validate(document, SCHEMA)


def test_json_holds_the_recorded_numbers_exactly(agent: SavedAgent, write: Export) -> None:
    document = json.loads(write(agent, "json").read_text("utf-8"))
    assert document["agent"]["title"] == agent.spec.title
    view = agent.forest_view()
    assert [option["id"] for option in document["options"]] == np.flatnonzero(
        view.is_alive
    ).tolist()
    assert document["options"][-1]["value"] == view.values[view.is_alive][-1].tolist()
    for episode, told in zip(agent.episodes, document["episodes"], strict=True):
        for decision, step in zip(episode.decisions, told["steps"], strict=True):
            assert step["decision"]["observation"] == decision.observation.tolist()
            assert step["decision"]["action_values"] == decision.action_values.tolist()
            path = step["decision"]["voters"][0]["path"]
            assert [element["option"] for element in path] == decision.path.tolist()
            assert path[-1]["distance"] == decision.distance


def test_csv_has_a_row_for_each_step(agent: SavedAgent, write: Export) -> None:
    with open(write(agent, "csv"), encoding="utf-8-sig", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == sum(len(episode) for episode in agent.episodes)
    decision = agent.episodes[1].decisions[7]
    row = rows[len(agent.episodes[0]) + 7]
    assert (row["episode"], row["step"]) == ("1", "7")
    seen = [float(v) for k, v in row.items() if k.startswith("observation ")]
    assert seen == decision.observation.tolist()
    assert row["path"] == " > ".join(map(str, decision.path.tolist()))
    assert float(row["margin"]) == decision.margin


def test_no_cell_of_a_csv_is_a_formula(hostile: SavedAgent, write: Export) -> None:
    for format in ("csv", "paths-csv"):
        with open(write(hostile, format), encoding="utf-8-sig", newline="") as stream:
            for row in csv.reader(stream):
                for cell in row:
                    assert not cell.startswith(("=", "@", "+", "\t"))
                    if cell.startswith("-"):
                        float(cell)  # A negative number is none.


def test_paths_csv_has_a_row_for_each_option_of_a_path(agent: SavedAgent, write: Export) -> None:
    with open(write(agent, "paths-csv", episode=0), encoding="utf-8-sig", newline="") as stream:
        rows = list(csv.DictReader(stream))
    decisions = agent.episodes[0].decisions
    assert len(rows) == sum(len(decision.path) for decision in decisions)
    at_step = [row for row in rows if row["step"] == "5"]
    assert [int(row["option"]) for row in at_step] == decisions[5].path.tolist()
    assert [float(row["distance"]) for row in at_step][-1] == decisions[5].distance


def test_parquet_gives_the_numbers_back(agent: SavedAgent, write: Export) -> None:
    table = pq.read_table(write(agent, "parquet"))
    rows = table.to_pylist()
    decisions = [d for episode in agent.episodes for d in episode.decisions]
    assert len(rows) == len(decisions)
    for row, decision in zip(rows, decisions, strict=True):
        assert row["observation"] == decision.observation.tolist()
        assert [element["option"] for element in row["path"]] == decision.path.tolist()
        assert row["action"] == decision.action
    names = json.loads(table.schema.metadata[b"ao2viz"])
    assert names["actions"] == list(agent.spec.action_names)
    assert HOSTILE_TITLE not in names["environment"]


def test_a_single_episode_is_exported_alone(cartpole: SavedAgent, write: Export) -> None:
    rows = pq.read_table(write(cartpole, "parquet", episode=1)).to_pylist()
    assert {row["episode"] for row in rows} == {1}
