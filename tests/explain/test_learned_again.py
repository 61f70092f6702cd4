"""Learning again: to the bit, without an episode, and with a ledger that adds up."""

from collections import Counter

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.training.loop import Stepper
from ao2viz.training.relearning import LearningStoppedError
from tests.explain.agents import bundled

PAPER = {
    "accumulate": {"failure_only": True},
    "return": {"credit": "return", "trace_length": 4},
    "bootstrap": {"credit": "bootstrap", "trace_length": 6, "epsilon": 0.1},
}


def paper(credit: str, steps: int = 400) -> AO2:
    return AO2("CartPole-v1", "paper", seed=3, **{"credit": credit, **PAPER[credit]}).learn(steps)


@pytest.mark.parametrize("credit", PAPER)
def test_the_ledger_adds_up_to_every_weight_to_the_bit(credit: str) -> None:
    agent = paper(credit)
    explain, view = agent.explain, agent.forest
    options = np.argsort(-view.visits.sum(axis=1))[:3].tolist()
    for option in options:
        for action in (0, 1):
            account = explain.ledger(option, action)
            assert account.is_exact
            total = sum(entry.portion for entry in account.entries) + account.expected
            assert total == pytest.approx(view.weights[option, action], rel=1e-9, abs=1e-12)
            if credit != "accumulate":
                assert account.movements == view.visits[option, action]


def test_entries_name_the_episode_and_step_that_really_were() -> None:
    agent = AO2("CartPole-v1", "paper", seed=3, credit="return", failure_only=False)
    seen = []
    agent.learn(300, lambda step: seen.append((len(agent.history), step)))
    view = agent.forest
    option, action = np.unravel_index(view.visits.argmax(), view.visits.shape)
    account = agent.explain.ledger(int(option), int(action))
    assert account.entries
    for entry in account.entries:
        before, result = seen[entry.step - 1]
        # The history already counts an episode whose last step this was.
        assert entry.episode == before - result.has_ended
        assert int(result.decision.voters[0]) == option
        assert result.decision.action == action
        assert entry.reward == seen[entry.step - 1 + entry.delay][1].reward
    episodes = account.by_episode()
    assert sum(episodes.values()) == pytest.approx(account.weight)
    told = agent.explain.tell(account).splitlines()
    assert told[0].startswith(f"Option {option} expects ")
    assert told[1].startswith(f"Training episode {next(iter(episodes))}: +")


def test_what_was_taught_in_parts_cannot_be_learned_again_and_says_so() -> None:
    agent = paper("return", 150).learn(150)
    with pytest.raises(ValueError, match="cannot be learned again exactly"):
        agent.explain.ledger(0, 0)
    changed = paper("return", 200)
    changed.set_decide_by("vote")
    with pytest.raises(ValueError, match="cannot be learned again exactly"):
        changed.explain.forget(0)


def test_a_ledger_is_of_weights_that_are_made_of_rewards() -> None:
    with pytest.raises(ValueError, match="ask for `weight`"):
        bundled("CartPole-v1").explain.ledger(0, 0)
    with pytest.raises(ValueError, match="no living option 99999"):
        paper("return", 60).explain.ledger(99_999, 0)


@pytest.mark.parametrize("preset", ["paper", "anticipating"])
def test_without_an_episode_nothing_of_it_is_known(
    preset: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    agent = AO2("CartPole-v1", preset, seed=5).learn(700)
    episode = len(agent.history) // 2
    played = Counter()
    step = Stepper.step

    def counted(stepper: Stepper):
        result = step(stepper)
        played[id(stepper)] += 1
        return result

    monkeypatch.setattr(Stepper, "step", counted)
    shares = []
    told = agent.explain.forget(episode, shares.append)
    assert list(played.values()) == [700, 700]
    assert shares == sorted(shares)
    assert 0 <= min(shares) < max(shares) < 1
    summary = agent.history.summaries[episode]
    assert (told.length, told.reward) == (summary.length, summary.total_reward)
    assert len(told.states) == len(agent.forest)
    assert told.options == len(agent.forest)
    for change in told.changed:
        assert agent.decide(told.states[change.place]).action == change.before != change.after
    assert "Training episode" in agent.explain.tell(told)


def test_forgetting_the_last_episode_is_having_stopped_before_it() -> None:
    agent = AO2("CartPole-v1", "paper", seed=5, credit="return")
    agent.learn(10_000, lambda step: len(agent.history) < 8)
    last = agent.history.summaries[-1]
    earlier = AO2("CartPole-v1", "paper", seed=5, credit="return")
    earlier.learn(last.end_step - last.length)
    told = agent.explain.forget(7)
    assert told.options_after == len(earlier.forest)
    changed = {change.place for change in told.changed}
    for place, state in enumerate(told.states):
        differs = agent.decide(state).action != earlier.decide(state).action
        assert differs == (place in changed)


def test_it_can_be_called_off_and_refuses_what_is_not_there() -> None:
    agent = paper("return", 500)
    with pytest.raises(LearningStoppedError, match="called off"):
        agent.explain.forget(0, lambda share: share < 0.2)
    with pytest.raises(ValueError, match="There is no training episode 10000"):
        agent.explain.forget(10_000)
    with pytest.raises(ValueError, match="counted from 0"):
        agent.explain.forget(-1)
