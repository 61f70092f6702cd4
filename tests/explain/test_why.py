"""Why, and why not that one: parts that add up to what decided, and sentences that quote them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from ao2viz.core.decision import DecideBy, Decision
from ao2viz.core.mind import Mind
from ao2viz.envs.task import TaskSpec
from ao2viz.explain.contrast import explain_why_not, tell_why_not
from ao2viz.explain.why import explain_why, tell_why
from tests.explain.agents import BUNDLED, bundled, minds, places, some_states
from tests.forests import SEEN, cartpole, decision, no_options, pendulum, plan, small_view

SPEC = cartpole()
PATH = {
    "decide_by": DecideBy.PATH,
    "voters": np.array([4]),
    "shares": np.array([1.0]),
    "voter_weights": np.array([[90.5, 92.25]]),
    "slopes": np.array([[0.0, 0.0, 10.0, 0.0], [0.0, 0.0, 60.0, 0.0]]),
    "action_values": np.array([90.0, 93.5]),
    "paths": np.array([[0, 1, 4]]),
    "path_distances": decision().path_distances[:1],
}


def check_parts(made: Decision, mind: Mind, spec: TaskSpec) -> None:
    why = explain_why(made, spec, mind.view)
    for part in why.weighings:
        whole = part.own + part.evened + sum(part.offsets)
        np.testing.assert_allclose(whole, part.outlook, rtol=1e-9, atol=1e-9)
    totals = [part.total for part in why.weighings]
    assert totals == made.action_values.tolist()
    assert why.is_faithful
    for other in range(len(totals)):
        if other == made.action:
            continue
        told = explain_why_not(made, other, mind.view)
        parts = sum(part.advantage for part in told.against) + told.evened + sum(told.offsets)
        np.testing.assert_allclose(parts + told.by_thinking, told.advantage, rtol=1e-9, atol=1e-9)
        assert told.advantage >= 0


@settings(deadline=None, max_examples=200)
@given(minds(), places())
def test_parts_add_up_to_what_the_agent_decided_by(mind: Mind, seen: np.ndarray) -> None:
    check_parts(mind.decide(seen), mind, pendulum())
    vote = Mind.from_view(mind.view, replace(mind.config, decide_by=DecideBy.VOTE))
    check_parts(vote.decide(seen), vote, pendulum())


@pytest.mark.parametrize("env_id", BUNDLED)
def test_they_do_on_trained_agents_thinking_or_not(env_id: str) -> None:
    agent = bundled(env_id)
    mind = agent.explain.mind
    thinking = Mind(replace(agent.config, think_ahead=2), agent.to_saved().state)
    for seen in some_states(agent, step=60):
        check_parts(mind.decide(seen), mind, agent.spec)
        check_parts(thinking.decide(seen), thinking, agent.spec)


def test_a_record_that_does_not_add_up_is_not_called_faithful() -> None:
    assert explain_why(decision(action_values=np.array([88.125, 92.0])), SPEC, small_view())
    honest = decision(action_values=np.array([0.75, 0.25]) @ decision().voter_weights)
    assert explain_why(honest, SPEC, small_view()).is_faithful
    assert not explain_why(replace(honest, action=0), SPEC, small_view()).is_faithful
    lying = replace(honest, shares=np.array([0.25, 0.75]))
    assert not explain_why(lying, SPEC, small_view()).is_faithful


def test_a_path_is_told_with_what_each_offset_adds() -> None:
    told = tell_why(explain_why(decision(**PATH), SPEC, small_view()), SPEC)
    assert told[0].startswith("Push right. Expected to earn 93.5 against 90.0 for push left")
    assert told[1] == (
        "The path, with distances: 0 (1.00), then 1 (0.400), then 4 (0.200). The next most "
        "similar, 1, is 0.200 further away."
    )
    assert told[2] == (
        "Push right: the option's own weight 92.250, +0.0500 from its neighbours, +1.20 for 1.15° "
        "more pole angle: 93.500."
    )
    assert told[3].startswith("Push left: the option's own weight 90.500, −0.700 from its")


def test_a_vote_is_told_by_its_loudest_voters() -> None:
    told = tell_why(explain_why(decision(), SPEC, small_view()), SPEC)
    assert "option 4 69.2 (0.750 of 92.2)" in told[2]


def test_without_options_there_is_little_to_tell() -> None:
    why = explain_why(no_options(is_tie=True), SPEC, small_view())
    assert why.is_faithful
    assert "There were no options to ask yet" in tell_why(why, SPEC)[0]
    told = explain_why_not(no_options(action=0), 1, small_view())
    assert tell_why_not(told, SPEC) == (
        "Nothing stood against push right: there were no options to ask yet."
    )


def test_of_an_option_that_is_gone_offsets_are_not_told() -> None:
    view = small_view()
    gone = replace(view, is_alive=np.array([True, True, True, True, False]))
    why = explain_why(decision(**PATH), SPEC, gone)
    assert np.isnan(why.offset).all()
    assert "its option is no longer there" in tell_why(why, SPEC)[2]


def test_what_stood_against_an_action_is_told_with_numbers_and_since_when() -> None:
    told = tell_why_not(explain_why_not(decision(**PATH), 0, small_view()), SPEC)
    assert told == (
        "Push left was expected to earn 90.0, push right 93.5: 3.50 more. Option 4 decided: by "
        "its own weights the difference is +1.75, its neighbours add +0.750, pole angle at 4.58° "
        "+1.00. It has been there since step 7; push right was tried there 12 times, push left 3 "
        "times. The most similar option that prefers push left is 2, at a distance of 1.60; "
        "3 options are nearer."
    )


def test_a_vote_tells_who_spoke_against_it() -> None:
    told = tell_why_not(explain_why_not(decision(), 0, small_view()), SPEC)
    assert "2 options spoke against it and 0 for it. Option 4, with 75 % of the say" in told


def test_chance_is_not_given_reasons() -> None:
    told = explain_why_not(decision(**PATH, explored=True, action=0), 1, small_view())
    text = tell_why_not(told, SPEC)
    assert text.startswith("Push left was drawn at random, to explore: nothing stood against push")
    assert "Expected were 90.0 of push left and 93.5 of push right." in text
    tie = decision(**{**PATH, "action_values": np.array([93.5, 93.5])}, is_tie=True)
    assert "Both were expected to earn 93.5; a toss decided for push right." in tell_why_not(
        explain_why_not(tie, 0, small_view()), SPEC
    )


def test_what_thinking_ahead_added_is_told() -> None:
    made = decision(plan=plan(outlook_values=np.array([90.25, 90.0])))
    told = explain_why_not(made, 0, small_view())
    assert told.by_thinking == pytest.approx(4.25 + 0.25)
    assert "Thinking ahead added +4.50 to the difference." in tell_why_not(told, SPEC)


@pytest.mark.parametrize("other", [1, 2, -1])
def test_an_action_that_is_not_another_one_is_refused(other: int) -> None:
    with pytest.raises(ValueError, match="another action than the chosen one"):
        explain_why_not(decision(), other, small_view())


def test_the_agent_answers_by_name_and_from_a_recording() -> None:
    agent = bundled("CartPole-v1")
    explain, recorded = agent.explain, agent.episodes[0].decisions[20]
    assert explain.why(recorded).decision is recorded
    assert explain.why(recorded.observation).decision.action == recorded.action
    other = agent.spec.action_names[1 - recorded.action]
    assert explain.why_not(recorded, other).other == 1 - recorded.action
    assert "was expected to earn" in explain.tell(explain.why_not(recorded, other))
    *lines, certain, faithful = explain.tell(explain.flips(SEEN)).splitlines()
    assert len(lines) == agent.spec.n_features
    assert certain.startswith("Certain: ")
    assert faithful.startswith("Faithfulness, tried at ")
    with pytest.raises(ValueError, match="There are: 0 \\(push left\\), 1 \\(push right\\)"):
        explain.why_not(recorded, "jump")
