"""Faithfulness: counted by asking the agent, with every answer, and never better than it is."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import DecideBy
from ao2viz.core.mind import Mind
from ao2viz.envs.ranges import ranges_of
from ao2viz.explain.agreement import Agreement, Check, Faithfulness, tell_faithfulness
from ao2viz.explain.faithful import Trials, check_contrast
from ao2viz.explain.plain import to_plain
from tests.explain.agents import BUNDLED, bundled, hand_made

ON_RECORDED = [check for check in Check if check is not Check.LEARNED]


def trials(agent: AO2, mind: Mind | None = None) -> Trials:
    decisions = [decision for episode in agent.episodes for decision in episode.decisions]
    asked = agent.explain.mind if mind is None else mind
    return Trials(asked, agent.spec, decisions, lambda: ranges_of(agent.env))


@pytest.mark.parametrize("env_id", BUNDLED)
def test_explanations_of_trained_agents_agree_with_them_wherever_tried(env_id: str) -> None:
    told = trials(bundled(env_id)).on(ON_RECORDED)
    for check in ON_RECORDED:
        assert told[check].tried >= 20, check
        # A weight is renewed when its turn comes, so a story may be ahead of it.
        assert told[check].share == 1.0 or check is Check.STORIES
    assert told.stories.share > 0.5
    assert told.are_recorded


@pytest.mark.parametrize("env_id", ["CartPole-v1", "Pendulum-v1"])
def test_every_answer_reports_how_faithful_such_answers_are(env_id: str) -> None:
    agent = bundled(env_id)
    explain, decision = agent.explain, agent.episodes[0].decisions[20]
    other = (decision.action + 1) % agent.spec.n_actions
    answers = [
        (explain.why(decision), "parts"),
        (explain.why_not(decision, other), "contrasts"),
        (explain.flips(decision), "flips"),
        (explain.nearest_flip(decision, 1.0), "lines"),
        (explain.nearest_flip_in_background(decision, 1.0).result(60.0), "lines"),
        (explain.ahead(decision, 3), "ways"),
        (explain.weight(int(decision.voters[0]), decision.action), "stories"),
        (explain.novelty(decision), "distances"),
        (explain.whole.overview(), "lines"),
        (explain.whole.carriers(1, episodes=1), "repeated"),
        (explain.disagreements(agent), "repeated"),
    ]
    for answer, name in answers:
        assert answer.faithfulness is not None
        assert getattr(answer.faithfulness, name).tried > 0
        assert explain.tell(answer).splitlines()[-1] == tell_faithfulness(answer.faithfulness)
        plain = json.loads(json.dumps(to_plain(answer), allow_nan=False))
        assert plain["faithfulness"][name]["tried"] == getattr(answer.faithfulness, name).tried


def test_what_is_learned_again_says_how_often_it_decides_the_same() -> None:
    agent = AO2("CartPole-v1", "paper", seed=1).learn(400)
    agent.record_episode(3)
    explain = agent.explain
    states = len(agent.episodes[0])
    for answer in (explain.ledger(0, 0), explain.forget(1)):
        assert answer.faithfulness == Faithfulness(learned=Agreement(states, states), states=states)
        assert explain.tell(answer).endswith(
            f"learned again, it decides the same in {states:,} of {states:,}."
        )


def test_records_that_are_not_the_agents_lower_the_count() -> None:
    agent = bundled("CartPole-v1")
    decisions = list(agent.episodes[0].decisions[:40])
    honest = Trials(agent.explain.mind, agent.spec, decisions, lambda: ranges_of(agent.env))
    lying = [
        replace(d, action=1 - d.action, explored=False) if n < 10 else d
        for n, d in enumerate(decisions)
    ]
    caught = Trials(agent.explain.mind, agent.spec, lying, lambda: ranges_of(agent.env))
    checks = (Check.PARTS, Check.CONTRASTS, Check.REPEATED)
    for check in checks:
        assert honest.on(checks)[check] == Agreement(40, 40)
        assert caught.on(checks)[check] == Agreement(30, 40)
    assert "30 of 40 parts add up" in tell_faithfulness(caught.on(checks))


def test_what_is_called_the_neighbours_part_is_held_against_the_plane_itself() -> None:
    agent = bundled("CartPole-v1")
    made = agent.episodes[0].decisions[30]
    # By adding up alone nobody would see it: what neighbours add is told as the rest.
    bent = replace(made, action_values=made.action_values + 3.0)
    checks = (Check.PARTS,)
    for decision, agreed in ((made, 1), (bent, 0)):
        tried = Trials(agent.explain.mind, agent.spec, [decision], lambda: ranges_of(agent.env))
        assert tried.on(checks).parts == Agreement(agreed, 1)


def test_a_contrast_whose_parts_do_not_add_up_is_not_called_faithful() -> None:
    mind = hand_made(
        [[0.0], [1.0], [2.0]],
        [[1, 0], [2, 1], [0, 3]],
        config=AnticipatingConfig(decide_by=DecideBy.VOTE),
    )
    made = mind.decide(np.array([0.2]))
    assert check_contrast(made, 1 - made.action, mind.view)
    bent = replace(made, voter_weights=made.voter_weights + np.array([[5.0, 0.0]]))
    assert not check_contrast(bent, 1 - bent.action, mind.view)


def test_without_recordings_the_options_stand_in_and_it_says_so() -> None:
    agent = AO2("CartPole-v1", "paper", seed=1).learn(200)
    told = agent.explain.why([0.0, 0.0, 0.05, 0.0]).faithfulness
    assert told is not None
    assert not told.are_recorded
    assert told.states == len(agent.forest)
    assert f"tried at {len(agent.forest)} options:" in tell_faithfulness(told)


@pytest.mark.parametrize("change", [{"decide_by": DecideBy.VOTE}, {"think_ahead": 2}])
def test_votes_and_plans_are_tried_as_far_as_they_can_be(change) -> None:
    agent = bundled("CartPole-v1")
    saved = agent.to_saved()
    assert isinstance(saved.config, AnticipatingConfig)
    mind = Mind(replace(saved.config, **change), saved.state)
    told = trials(agent, mind).on([Check.PARTS, Check.LINES, Check.FLIPS, Check.CERTAIN])
    assert told.parts.share == told.flips.share == 1.0
    assert told.lines == told.certain == Agreement(0, 0)  # Those are of one option's plane.
    assert "certain" not in tell_faithfulness(told)
