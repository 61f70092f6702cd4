"""Whatever export explains, it says how often such explanations agree with the agent."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest

from ao2viz.exports.export import choose
from ao2viz.store.saved import SavedAgent
from tests.exports.conftest import Export

SAID = "Faithfulness, tried at 80 recorded states: 80 of 80 parts add up to the choice; asked again"


def lying(agent: SavedAgent) -> SavedAgent:
    """The agent with one decision recorded as the other action than it was."""
    episode = agent.episodes[0]
    decisions = list(episode.decisions)
    decisions[3] = replace(decisions[3], action=1 - decisions[3].action)
    episodes = (replace(episode, decisions=tuple(decisions)), *agent.episodes[1:])
    return replace(agent, episodes=episodes)


@pytest.mark.parametrize(
    ("format", "chosen"),
    [("markdown", {}), ("html", {}), ("path-svg", {}), ("svg", {"step": 3}), ("latex", {})],
)
def test_pages_and_pictures_say_it(
    cartpole: SavedAgent, write: Export, format: str, chosen: dict
) -> None:
    text = write(cartpole, format, **chosen).read_text("utf-8")
    told = " ".join(re.sub(r"<[^>]*>", " ", text).split())
    assert SAID in told
    if format != "latex" and "step" not in chosen:
        caught = write(lying(cartpole), format, overwrite=True).read_text("utf-8")
        assert "79 of 80" in " ".join(re.sub(r"<[^>]*>", " ", caught).split())


def test_tables_say_it_of_every_step(cartpole: SavedAgent, write: Export) -> None:
    agent = lying(cartpole)
    for format in ("csv", "paths-csv"):
        with open(write(agent, format), encoding="utf-8-sig", newline="") as stream:
            rows = list(csv.DictReader(stream))
        wrong = {(row["episode"], row["step"]) for row in rows if row["faithful"] == "0"}
        assert wrong == {("0", "3")}
        assert {row["faithful"] for row in rows} == {"0", "1"}
    table = pq.read_table(write(agent, "parquet"))
    assert np.flatnonzero(~np.array(table["is_faithful"])).tolist() == [3]
    kept = json.loads(table.schema.metadata[b"ao2viz"])["faithfulness"]
    document = json.loads(write(agent, "json").read_text("utf-8"))
    assert document["faithfulness"] == kept
    assert kept["parts"] == kept["repeated"] == {"agreed": 79, "tried": 80}
    assert [s["is_faithful"] for s in document["episodes"][0]["steps"]].index(False) == 3


@pytest.mark.parametrize("name", ["cartpole", "pendulum"])
def test_the_policy_file_was_run_and_says_how_often_it_agrees(
    name: str, write: Export, request: pytest.FixtureRequest
) -> None:
    source = write(request.getfixturevalue(name), "policy").read_text("utf-8")
    assert "Tried at 80 recorded states: it chooses as the agent does at 80." in source
    bare = replace(request.getfixturevalue(name), episodes=())
    source = write(bare, "policy", overwrite=True).read_text("utf-8")
    assert "Tried at 400 options: it chooses as the agent does at 400." in source


def test_it_is_counted_once_and_over_the_chosen_episodes(cartpole: SavedAgent) -> None:
    content = choose(cartpole, episode=1)
    assert content.faithfulness is content.faithfulness
    assert content.faithfulness.parts.tried == 40
