"""One option leaves as notes and as JSON, with everything that is known of it."""

import json

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.explain.plain import to_plain
from ao2viz.store.saved import SavedAgent
from tests.exports.agents import HOSTILE
from tests.exports.conftest import Export
from tests.exports.test_pages import cells


@pytest.mark.parametrize("name", ["cartpole", "pendulum"])
def test_json_holds_what_the_agent_knows_of_the_option(
    name: str, write: Export, request: pytest.FixtureRequest
) -> None:
    saved = request.getfixturevalue(name)
    chosen = int(saved.episodes[0].decisions[5].voters[0])
    document = json.loads(write(saved, "option-json", option=chosen).read_text("utf-8"))
    assert (document["format"], document["version"]) == ("ao2viz-option", 1)
    told, view = document["option"], saved.forest_view()
    assert told["value"] == view.values[chosen].tolist()
    assert told["weights"] == view.weights[chosen].tolist()
    assert told["visits"] == view.visits[chosen].tolist()
    assert told["parents"] == view.parents_of(chosen).tolist()
    assert told["children"][: len(view.children_of(chosen))] == view.children_of(chosen).tolist()
    assert [origin["action"] for origin in told["origins"]] == list(range(saved.spec.n_actions))
    uses = {(use["episode"], use["step"]) for use in told["uses"]}
    assert uses == {
        (n, t)
        for n, episode in enumerate(saved.episodes)
        for t, decision in enumerate(episode.decisions)
        if chosen in decision.voters[decision.shares > 0]
    }
    answer = to_plain(AO2.from_saved(saved).explain.option(chosen))
    assert {k: v for k, v in answer.items() if k != "faithfulness"} == {
        k: v for k, v in told.items() if k != "faithfulness"
    }
    assert told["faithfulness"]["stories"]["tried"] > 0


def test_notes_tell_value_weights_reasons_and_uses(cartpole: SavedAgent, write: Export) -> None:
    page = write(cartpole, "option", option=0).read_text("utf-8")
    for words in ("# Option 0", "stands for", "expected return", "Why so much for push left",
                  "Where it had a say", "Faithfulness, tried at", "Children: "):  # fmt: skip
        assert words in page
    rows = [line for line in page.splitlines() if line.startswith("| push ")]
    visits = [int(row.split("|")[3].replace(",", "")) for row in rows]
    assert visits == cartpole.forest_view().visits[0].tolist()


def test_hostile_names_stay_names(hostile: SavedAgent, write: Export) -> None:
    page = write(hostile, "option", option=0).read_text("utf-8")
    assert "<script" not in page.replace(r"\<script", "")
    assert {" ".join(name.split()) for name in HOSTILE} <= set(cells(page))
    assert json.loads(write(hostile, "option-json", option=0).read_text("utf-8"))


def test_an_option_of_the_paper_preset_has_no_stories(tmp_path) -> None:
    agent = AO2("CartPole-v1", "paper", seed=1).learn(200)
    told = agent.explain.option(0)
    assert told.origins == ()
    assert np.array_equal(told.weights, agent.forest.weights[0])
    assert agent.explain.tell(told).startswith("Option 0, a root, made at step")


@pytest.mark.parametrize(
    ("chosen", "words"), [({}, "name it with --option"), ({"option": 10**6}, "no living option")]
)
def test_what_is_no_option_is_told(
    cartpole: SavedAgent, write: Export, chosen: dict, words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        write(cartpole, "option", **chosen)
