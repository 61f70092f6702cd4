"""Learning again from the page: without an episode, and for a ledger; with progress and an end."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ao2viz.agent import AO2
from ao2viz.explain.forgetting import Forgotten
from ao2viz.explain.ledger import Account
from ao2viz.store.saved import SavedAgent
from ao2viz.ui import html_again
from ao2viz.ui.again import again_of, forget_subject, ledger_subject
from ao2viz.ui.downloads import Notify
from ao2viz.ui.jobs import Jobs, JobState
from ao2viz.ui.questions import ChooseForgotten, Forget, KeepLedger, Task
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session
from ao2viz.ui.world import World
from tests.ui.agents import saved_agent

FILE = Path("here.ao2")


@pytest.fixture(scope="module")
def paper() -> AO2:
    agent = AO2("CartPole-v1", "paper", seed=1, credit="return").learn(400)
    agent.record_episode(3)
    return agent


def watching(saved: SavedAgent) -> tuple[Session, World]:
    return Session(source=FILE), World(opened={FILE: saved})


def done(jobs: Jobs, task: Task, about: tuple, is_enough: Callable[[JobState], bool]) -> JobState:
    deadline = time.monotonic() + 60
    while True:
        state = jobs.look(task, about)
        if state is not None and is_enough(state):
            return state
        assert time.monotonic() < deadline, "It never came to that."
        time.sleep(0.005)


def test_an_episode_is_forgotten_beside_the_page_and_told_with_its_moments(paper: AO2) -> None:
    session, w = watching(paper.to_saved())
    session, _ = reduce(session, ChooseForgotten(2), w)
    _, (begin,) = reduce(session, Forget(), w)
    jobs = Jobs()
    jobs.begin(begin)
    about = forget_subject(again_of(session, w))
    state = done(jobs, Task.FORGET, about, lambda s: s.is_done)
    told = state.latest
    assert isinstance(told, Forgotten)
    expected = paper.explain.forget(2)
    assert [c.place for c in told.changed] == [c.place for c in expected.changed]
    words = html_again.forgotten(state, paper.spec)
    assert "Training episode 2 had" in words
    assert "learned again, it decides the same in" in words
    # Another episode is another question.
    session, _ = reduce(session, ChooseForgotten(3), w)
    assert jobs.look(Task.FORGET, forget_subject(again_of(session, w))) is None


def test_a_ledger_is_kept_of_the_weight_that_is_open(paper: AO2) -> None:
    session, w = watching(paper.to_saved())
    assert isinstance(reduce(session, KeepLedger(), w)[1][0], Notify)
    session = replace(session, selected=0, opened=1)
    _, (begin,) = reduce(session, KeepLedger(), w)
    jobs = Jobs()
    jobs.begin(begin)
    about = ledger_subject(again_of(session, w))
    state = done(jobs, Task.LEDGER, about, lambda s: s.is_done)
    assert isinstance(state.latest, Account)
    assert state.latest.is_exact
    assert state.latest.entries == paper.explain.ledger(0, 1).entries
    assert "Option 0 expects" in html_again.account(state, paper.spec)


def test_it_tells_how_far_it_is_and_ends_when_called_off() -> None:
    agent = AO2("CartPole-v1", "paper", seed=1).learn(6000)
    session, w = watching(agent.to_saved())
    _, (begin,) = reduce(session, Forget(), w)
    jobs = Jobs()
    jobs.begin(begin)
    about = forget_subject(again_of(session, w))
    state = done(jobs, Task.FORGET, about, lambda s: isinstance(s.latest, float) and s.latest > 0)
    assert not state.is_done
    assert 0 < html_again.share_of(state) < 1
    assert "Learning again, " in html_again.forgotten(state, agent.spec)
    jobs.call_off(Task.FORGET)
    state = done(jobs, Task.FORGET, about, lambda s: s.is_done)
    assert state.error == "Called off; nothing came of it."
    assert state.error in html_again.forgotten(state, agent.spec)


def test_what_cannot_be_learned_again_says_so_in_the_place_of_the_answer() -> None:
    agent = AO2("CartPole-v1", "paper", seed=1).learn(200)
    agent.learn(200)
    session, w = watching(agent.to_saved())
    _, (begin,) = reduce(session, Forget(), w)
    jobs = Jobs()
    jobs.begin(begin)
    state = done(jobs, Task.FORGET, forget_subject(again_of(session, w)), lambda s: s.is_done)
    assert "cannot be learned again exactly" in html_again.forgotten(state, agent.spec)


@pytest.mark.parametrize(
    ("session", "saved", "said"),
    [
        (Session(source=None), None, "save the run"),
        (Session(source=FILE), saved_agent(), "has finished no training episode"),
    ],
)
def test_where_there_is_nothing_to_forget_it_says_why(
    session: Session, saved: Any, said: str
) -> None:
    w = World(opened={} if saved is None else {FILE: saved})
    assert said in again_of(session, w).problem
    _, (notice,) = reduce(session, Forget(), w)
    assert isinstance(notice, Notify)
    assert said in notice.body


def test_an_episode_that_is_not_there_becomes_the_last_one(paper: AO2) -> None:
    session, w = watching(paper.to_saved())
    session, _ = reduce(session, ChooseForgotten(10**6), w)
    assert again_of(session, w).episode == len(paper.history.summaries) - 1
    session, _ = reduce(session, ChooseForgotten(-4), w)
    assert again_of(session, w).episode == 0
