"""Branches: the same agent's own actions give the same episode, others give another, exactly."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.mind import Mind
from ao2viz.recording.episode import Episode
from ao2viz.resources import saved_schemas
from ao2viz.store.files import read
from ao2viz.store.saved import SavedAgent
from ao2viz.training.branching import BranchStoppedError, Takeover, play_branch
from ao2viz.training.replay import replay_pictures


@cache
def bundled(env_id: str) -> tuple[SavedAgent, Mind]:
    saved = read(saved_schemas() / f"{env_id}.ao2")
    return saved, Mind(saved.config, saved.state)


def greedy(saved: SavedAgent) -> Episode:
    return next(episode for episode in saved.episodes if not episode.is_training)


def branch(env_id: str, *takeovers: tuple[int, int], limit: int = 0, **more) -> Episode:
    saved, mind = bundled(env_id)
    chosen = [Takeover(*each) for each in takeovers]
    return play_branch(greedy(saved), saved.spec, chosen, mind.decide, limit, **more)


@given(st.data())
@settings(max_examples=8, deadline=None)
@pytest.mark.parametrize("env_id", ["CartPole-v1", "Pendulum-v1", "MountainCar-v0"])
def test_with_the_agents_own_action_a_branch_is_the_main_line(env_id, data):
    main = greedy(bundled(env_id)[0])
    step = data.draw(st.integers(0, len(main) - 1))
    again = branch(env_id, (step, int(main.actions[step])))
    for name in ("observations", "actions", "rewards"):
        np.testing.assert_array_equal(getattr(again, name), getattr(main, name))
    assert (again.terminated, again.truncated) == (main.terminated, main.truncated)
    assert [d.action for d in again.decisions] == main.actions.tolist()


@given(st.data())
@settings(max_examples=12, deadline=None)
def test_a_branch_is_the_recording_until_a_person_chooses_and_greedy_afterwards(data):
    saved, mind = bundled("CartPole-v1")
    main = greedy(saved)
    step = data.draw(st.integers(0, len(main) - 1))
    other = 1 - int(main.actions[step])
    made = branch("CartPole-v1", (step, other))
    np.testing.assert_array_equal(made.observations[: step + 1], main.observations[: step + 1])
    assert made.actions[:step].tolist() == main.actions[:step].tolist()
    assert made.actions[step] == other
    assert made.decisions[: step + 1] == main.decisions[: step + 1]
    for t in range(step + 1, len(made)):
        assert made.actions[t] == made.decisions[t].action
        np.testing.assert_array_equal(made.decisions[t].observation, made.observations[t])
    if step < len(made) - 1:
        assert made.actions[-1] == mind.decide(made.observations[-2]).action
    assert len(list(replay_pictures(made, saved.spec))) == len(made) + 1


def test_a_branch_can_be_taken_over_again():
    one = branch("CartPole-v1", (10, 0))
    both = branch("CartPole-v1", (10, 0), (14, 1), (15, 1))
    np.testing.assert_array_equal(both.observations[:15], one.observations[:15])
    assert both.actions[14:16].tolist() == [1, 1]


def test_a_branch_ends_after_so_many_steps_if_asked():
    made = branch("CartPole-v1", (10, 0), limit=5)
    assert len(made) == 16
    assert not made.terminated
    assert not made.truncated


def test_a_recording_that_is_not_repeated_is_said():
    saved, mind = bundled("CartPole-v1")
    main = greedy(saved)
    moved = main.observations.copy()
    moved[4] += 0.1
    changed = Episode(**{**vars(main), "observations": moved})
    with pytest.raises(ValueError, match="no longer repeats this recording: step 4"):
        play_branch(changed, saved.spec, [Takeover(6, 0)], mind.decide)
    play_branch(changed, saved.spec, [Takeover(2, 0)], mind.decide, 1)  # Before that all is well.


def test_a_branch_that_ends_before_a_takeover_is_no_branch():
    falls = [(t, 0) for t in range(30)]
    with pytest.raises(ValueError, match="ended at step"):
        branch("CartPole-v1", *falls)


def test_a_branch_can_be_called_off_and_tells_how_far_it_is():
    told: list[int] = []

    def tell(steps: int) -> bool:
        told.append(steps)
        return steps < 20

    with pytest.raises(BranchStoppedError, match="called off"):
        branch("CartPole-v1", (10, 0), on_step=tell)
    assert told == list(range(21))
