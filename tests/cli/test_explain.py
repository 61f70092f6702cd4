"""`ao2viz explain`, as a process: every question, for people and for programs."""

import json
from pathlib import Path

import pytest

import ao2viz
from ao2viz.resources import saved_schemas
from tests.cli.processes import Cli

FILE = str(saved_schemas() / "CartPole-v1.ao2")


def asked(cli: Cli, *arguments: str) -> dict:
    done = cli("explain", FILE, *arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_why_tells_the_recorded_decision_in_sentences_and_tables(cli: Cli) -> None:
    decision = ao2viz.AO2.load(FILE).episodes[0].decisions[20]
    result = asked(cli, "why", "--episode", "0", "--step", "20")
    assert result["answer"]["decision"]["observation"] == decision.observation.tolist()
    assert result["answer"]["decision"]["action"] == decision.action
    assert result["answer"]["is_faithful"] is True
    assert result["actions"] == ["push left", "push right"]
    done = cli("explain", FILE, "--episode", "0", "--step", "20")
    assert done.returncode == 0
    for sentence in result["sentences"]:
        assert sentence in done.stdout
    for heading in ("Seen: cart position", "Path", "own weight", "neighbours"):
        assert heading in done.stdout


def test_every_question_is_answered_about_an_observation(cli: Cli) -> None:
    agent = ao2viz.AO2.load(FILE)
    seen = [0.0, 0.1, 0.01, -0.1]
    decision = agent.decide(seen)
    arguments = ("--observation", ",".join(map(str, seen)))
    flips = asked(cli, "flip", *arguments)["answer"]
    assert flips["certificate"]["radius"] > 0
    assert len(flips["features"]) == 4
    nearest = asked(cli, "nearest-flip", *arguments, "--time-limit", "5")["answer"]
    assert agent.decide(nearest["flipped"]).action != decision.action
    assert nearest["distance"] >= flips["certificate"]["radius"]
    other = agent.spec.action_names[1 - decision.action]
    why_not = asked(cli, "why-not", *arguments, "--action", other)["answer"]
    assert why_not["advantage"] == pytest.approx(decision.margin)
    ahead = asked(cli, "ahead", *arguments, "--steps", "7")["answer"]
    assert len(ahead["steps"]) == 7
    weight = asked(cli, "weight", *arguments)["answer"]
    assert (weight["option"], weight["action"]) == (int(decision.voters[0]), decision.action)
    assert asked(cli, "novelty", *arguments)["answer"]["is_alarm"] is False


def test_what_the_solver_prints_by_itself_stays_out_of_the_result(cli: Cli) -> None:
    # Around this state the solver's library prints lines of its own, past Python.
    file = str(saved_schemas() / "MountainCar-v0.ao2")
    arguments = ("--episode", "1", "--step", "6", "--time-limit", "30", "--json")
    done = cli("explain", file, "nearest-flip", *arguments)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["answer"]["flipped"] is not None


def test_a_weight_is_told_by_option_and_action_number(cli: Cli) -> None:
    done = cli("explain", FILE, "weight", "--option", "0", "--action", "1")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Option 0 expects ")
    assert "of push right" in done.stdout


def test_an_option_is_told_in_full(cli: Cli) -> None:
    answer = asked(cli, "option", "--option", "0")["answer"]
    forest = ao2viz.AO2.load(FILE).forest
    assert answer["visits"] == forest.visits[0].tolist()
    assert [origin["weight"] for origin in answer["origins"]] == forest.weights[0].tolist()
    assert answer["faithfulness"]["stories"]["tried"] > 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("why-not",), "Why not which action? Name it with --action; there are: push left, push"),
        (("why-not", "--action", "jump"), "Expected an action of CartPole-v1, but got 'jump'"),
        (("why", "--episode", "9"), "There is no recorded episode 9; they go from 0 to 1."),
        (("why", "--step", "9999"), "There is no step 9999 in episode 1"),
        (("why", "--observation", "a,b"), "Expected --observation as numbers with commas"),
        (("why", "--observation", "1,2"), "one number per feature of CartPole-v1"),
        (("why", "--observation", "0,0,0,0", "--step", "1"), "Give either --observation, or"),
        (("weight", "--option", "999999"), "There is no living option 999999"),
        (("why", "--time-limit", "-1"), "--time-limit"),
        (("whence",), "whence"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_line(
    cli: Cli, arguments: tuple[str, ...], said: str
) -> None:
    done = cli("explain", FILE, *arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert done.stdout == ""


def test_without_recorded_episodes_it_says_what_to_do(cli: Cli, tmp_path: Path) -> None:
    ao2viz.AO2("CartPole-v1", preset="paper").learn(30).save(tmp_path / "young.ao2")
    done = cli("explain", "young.ao2")
    assert done.returncode == 2
    assert "give an --observation, or record one with ao2viz record" in done.stderr
    done = cli("explain", "young.ao2", "ahead", "--observation", "0,0,0,0")
    assert done.returncode == 2
    assert "this one imagines nothing" in done.stderr


def test_a_paper_agent_tells_its_ledger_and_forgets_an_episode(cli: Cli, tmp_path: Path) -> None:
    agent = ao2viz.AO2("CartPole-v1", preset="paper", seed=1, credit="return").learn(400)
    agent.save(tmp_path / "paper.ao2")
    arguments = ("explain", "paper.ao2", "weight", "--option", "0", "--action", "0", "--json")
    done = cli(*arguments)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)["answer"]
    assert answer["is_exact"] is True
    assert answer["weight"] == agent.forest.weights[0, 0]
    done = cli("explain", "paper.ao2", "forget", "--forget", "2", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["answer"]["length"] == agent.history.summaries[2].length
    done = cli("explain", "paper.ao2", "forget")
    assert done.returncode == 2
    assert "Name it with --forget" in done.stderr


def test_the_whole_agent_is_told_and_compared(cli: Cli, tmp_path: Path) -> None:
    agent = ao2viz.AO2("CartPole-v1", preset="paper", seed=1).learn(300)
    agent.record_episode(1)
    agent.save(tmp_path / "paper.ao2")
    done = cli("explain", "paper.ao2", "agent", "--json")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)["answer"]
    assert answer["coverage"]["share"] > 0
    assert answer["faithfulness"]["parts"]["agreed"] == answer["faithfulness"]["parts"]["tried"]
    done = cli("explain", "paper.ao2", "mute", "--option", "0", "--episodes", "1")
    assert done.returncode == 0, done.stderr
    assert "Without option 0: " in done.stdout
    done = cli("explain", "paper.ao2", "disagree", "--other", FILE)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("They disagree in ")
    done = cli("explain", "paper.ao2", "disagree")
    assert done.returncode == 2
    assert "Name another agent's file with --other" in done.stderr
