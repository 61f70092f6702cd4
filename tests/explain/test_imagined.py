"""What is imagined: the way ahead, and the story behind a weight, both exactly the agent's own."""

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.core.config import PaperConfig
from ao2viz.explain.ahead import AheadEnd, look_ahead, tell_ahead
from ao2viz.explain.origin import explain_weight, tell_origin
from tests.explain.agents import BUNDLED, bundled, hand_made, some_states


@pytest.fixture(scope="module", params=["CartPole-v1", "MountainCar-v0"])
def rested(request: pytest.FixtureRequest) -> AO2:
    """An agent that has just imagined everything anew."""
    agent = AO2(request.param, seed=4, story_length=12)
    return agent.learn(1_500)


def all_weights(agent: AO2):
    view = agent.forest
    for option in np.flatnonzero(view.is_alive).tolist():
        for action in range(view.weights.shape[1]):
            yield option, action


def test_retold_right_after_it_was_imagined_a_story_is_the_one_that_is_kept(rested: AO2) -> None:
    mind, known = rested.explain.mind, 0
    for option, action in all_weights(rested):
        origin = explain_weight(mind, option, action)
        assert not origin.has_moved_on
        known += bool(origin.story.steps)
        # Sleep ends when no value moves by more than a ten-thousandth of the greatest.
        scale = np.abs(mind.view.weights).max()
        assert origin.explained == pytest.approx(origin.weight, abs=2e-3 * scale)
    assert known > 100


def test_the_steps_of_a_story_add_up_to_it(rested: AO2) -> None:
    mind, gamma = rested.explain.mind, rested.config.gamma
    for option, action in list(all_weights(rested))[::5]:
        origin = explain_weight(mind, option, action)
        earned, discount = 0.0, 1.0
        for step in origin.story.steps:
            earned += discount * step.reward
            discount *= gamma * (1 - step.ending)
            assert step.visits > 0
        if origin.story.steps:
            assert earned == pytest.approx(origin.story.reward)
            assert discount == pytest.approx(origin.story.discount)
            assert sum(end.share for end in origin.ends) == pytest.approx(1, abs=1e-6)


def test_kept_traces_count_where_they_earned_more(rested: AO2) -> None:
    origins = [explain_weight(rested.explain.mind, *pair) for pair in all_weights(rested)]
    by_trace = [origin for origin in origins if origin.is_by_trace]
    assert by_trace
    for origin in by_trace:
        assert origin.trace is not None
        assert not origin.trace.worth <= origin.imagined
        assert origin.explained == origin.trace.worth
    assert "A real trace that earned more" in "\n".join(tell_origin(by_trace[0], rested.spec))


def test_after_more_experience_it_says_that_experience_has_moved_on() -> None:
    agent = AO2("CartPole-v1", seed=4).learn(1_000)
    stepper = agent.stepper()
    for _ in range(60):
        stepper.step()
    explain = agent.explain
    origins = [explain.weight(*pair) for pair in all_weights(agent)]
    moved = [origin for origin in origins if origin.has_moved_on]
    assert moved
    assert len(moved) < len(origins)
    assert "Experience has moved on" in explain.tell(moved[0])


@pytest.mark.parametrize("env_id", BUNDLED)
def test_the_way_ahead_is_what_the_agent_would_do_and_expects(env_id: str) -> None:
    agent = bundled(env_id)
    mind = agent.explain.mind
    for seen in some_states(agent, step=60):
        ahead = look_ahead(mind, seen, limit=12)
        here, earned = seen, 0.0
        for step in ahead.steps:
            np.testing.assert_array_equal(step.observation, here)
            assert step.action == mind.act(here)
            expected = mind.expect(here, step.action)
            assert expected is not None
            assert (step.reward, step.visits) == (expected.reward, expected.visits)
            here = expected.after
            earned += step.reward * (step.continues / (1 - step.ending) if step.ending < 1 else 0)
        np.testing.assert_array_equal(ahead.last, here)
        assert ahead.reward == pytest.approx(earned, rel=1e-6) or any(
            step.ending == 1 for step in ahead.steps
        )
        assert sum(map(len, ahead.stretches)) == len(ahead.steps)


def test_predictions_resemble_what_then_happened() -> None:
    agent = bundled("Pendulum-v1")
    episode, attention = agent.episodes[0], agent.forest.attention
    errors = []
    for t in range(0, 150, 10):
        ahead = agent.explain.ahead(episode.observations[t], limit=3)
        errors.append(attention @ np.abs(ahead.last - episode.observations[t + 3]))
    assert np.median(errors) < 0.5**4  # The finest radius.


def test_it_says_how_the_way_ends() -> None:
    agent = bundled("CartPole-v1")
    seen = agent.episodes[0].observations[30]
    ahead = agent.explain.ahead(seen, limit=5)
    assert ahead.end is AheadEnd.LIMIT
    told = tell_ahead(ahead, agent.spec)
    assert told[0].startswith("Near option ")
    assert told[-1].startswith("5 steps ahead, 5.00 earned, and a chance of 100 % that it goes on")
    away = agent.explain.ahead([4.0, 60.0, 0.4, 60.0])
    assert away.end is AheadEnd.UNKNOWN
    assert away.steps == ()
    assert "it does not know what its action does" in agent.explain.tell(away)
    falling = agent.explain.ahead([0.0, 0.0, 0.205, 2.0])
    assert falling.end in (AheadEnd.ENDED, AheadEnd.UNKNOWN)


def test_an_agent_that_imagines_nothing_says_so() -> None:
    mind = hand_made([[0.0]], [[1, 0]], config=PaperConfig())
    for ask in (lambda: look_ahead(mind, np.zeros(1)), lambda: explain_weight(mind, 0, 0)):
        with pytest.raises(ValueError, match="this one imagines nothing"):
            ask()


def test_what_is_not_there_is_refused() -> None:
    agent = bundled("CartPole-v1")
    dead = int(np.flatnonzero(~agent.forest.is_alive)[0])
    for option in (dead, -1, 10**6):
        with pytest.raises(ValueError, match="There is no living option"):
            agent.explain.weight(option, 0)
    with pytest.raises(ValueError, match="Expected an action"):
        explain_weight(agent.explain.mind, int(agent.forest.children_of(0)[0]), 7)
    with pytest.raises(ValueError, match="from 1 to 1,000 steps"):
        agent.explain.ahead(np.zeros(4), limit=0)


def test_a_weight_is_told_step_by_step() -> None:
    agent = bundled("CartPole-v1")
    option = int(agent.episodes[0].decisions[10].voters[0])
    told = agent.explain.tell(agent.explain.weight(option, "push left")).splitlines()
    assert told[0].startswith(f"Option {option} expects ")
    assert told[1].startswith("1. push left: earns 1.00, to cart position ")
    assert told[-3].startswith("It ends near ")
    assert told[-2].startswith("So ")
    assert told[-1].startswith("Faithfulness, tried at ")
