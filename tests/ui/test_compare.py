"""Compare: which agents fit, what is asked of the two, and how it is told."""

import time
from dataclasses import replace
from pathlib import Path

import pytest

from ao2viz.agent import AO2
from ao2viz.envs.task import describe, make_env
from ao2viz.training.states import RunStatus
from ao2viz.training.updates import RunUpdate
from ao2viz.ui import html_compare
from ao2viz.ui.comparing import begin_beside
from ao2viz.ui.downloads import Notify
from ao2viz.ui.jobs import Begin, Jobs
from ao2viz.ui.library import Library
from ao2viz.ui.questions import ChooseDuelSeed, ChooseOther, Fight, SeekDuel, Task
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session
from ao2viz.ui.view import project
from ao2viz.ui.watched import learned_of
from ao2viz.ui.world import LoadFailure, ShelfItem, World
from tests.forests import cartpole, small_view
from tests.ui.agents import saved_agent
from tests.ui.test_panels import EVIL, hostile_spec

ONE, OTHER = Path("/agents/one.ao2"), Path("/agents/other.ao2")


@pytest.fixture(scope="module")
def agents() -> list[AO2]:
    made = [AO2("CartPole-v1", seed=s, warmup_steps=50, levels=1).learn(200) for s in (0, 1)]
    for agent in made:
        agent.record_episode(1)
    return made


def world_of(one, other, **more) -> World:
    shelf = (ShelfItem(ONE, "one"), ShelfItem(OTHER, "other"))
    return World(shelf=shelf, opened={ONE: one, OTHER: other}, **more)


def with_other(w: World, **more) -> Session:
    session = Session(source=ONE, is_playing=False, **more)
    return reduce(session, ChooseOther(OTHER), w)[0]


def test_an_agent_of_the_same_task_can_be_put_beside():
    w = world_of(saved_agent(), saved_agent())
    other = project(with_other(w), w).other
    assert other.agent is w.opened[OTHER]
    assert project(Session(source=ONE), w).other is None


@pytest.mark.parametrize(
    ("opened", "words"),
    [
        (LoadFailure("Cannot open other.ao2: broken."), "broken"),
        (saved_agent(spec=describe(make_env("Acrobot-v1"))), "does not fit CartPole-v1"),
    ],
)
def test_what_cannot_be_compared_is_told_in_words(opened, words):
    w = world_of(saved_agent(), opened)
    session = with_other(w)
    other = project(session, w).other
    assert other.agent is None
    assert words in other.words
    _, effects = reduce(session, Fight(), w)
    assert isinstance(effects[0], Notify)
    assert words in effects[0].body


def test_a_file_that_is_not_on_the_shelf_is_not_opened():
    w = world_of(saved_agent(), saved_agent())
    session, effects = reduce(Session(source=ONE), ChooseOther(Path("/etc/passwd")), w)
    assert session.other is None
    assert isinstance(effects[0], Notify)


def test_while_a_run_goes_on_nothing_is_compared():
    running = RunUpdate(status=RunStatus.RUNNING, forest=small_view(), spec=cartpole())
    w = world_of(saved_agent(), saved_agent(), update=running)
    session = replace(with_other(w), source=None)
    _, effects = reduce(session, Fight(), w)
    assert "Hold the run" in effects[0].body


def test_the_two_play_from_the_chosen_seed(agents):
    w = world_of(*(agent.to_saved() for agent in agents))
    session = reduce(with_other(w), ChooseDuelSeed(5), w)[0]
    session = reduce(session, SeekDuel(9), w)[0]
    assert project(session, w).other.step == 9
    session, (begin,) = reduce(session, Fight(), w)
    assert isinstance(begin, Begin)
    assert (begin.task, session.duel_step) == (Task.DUEL, 0)
    jobs = Jobs()
    jobs.begin(begin)
    state = ended(jobs, begin)
    assert state.error == ""
    assert state.latest.one.actions.tolist() == agents[0].record_episode(5).actions.tolist()
    assert state.latest.played == 20
    page = html_compare.duel(state, 0, w.opened[ONE].spec)
    assert "pole angle" in page
    assert "20 of 20 episodes each" in html_compare.duel_returns(state)


def ended(jobs: Jobs, begin: Begin):
    deadline = time.monotonic() + 120
    while True:
        state = jobs.look(begin.task, begin.about)
        if state is not None and state.is_done:
            return state
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_comparison_is_told_and_its_names_are_only_names(agents):
    w = world_of(*(agent.to_saved() for agent in agents))
    session = with_other(w)
    one, other = w.opened[ONE], w.opened[OTHER]
    begin = begin_beside(learned_of(session, w), one.episodes[0], one.episodes, other)
    jobs = Jobs()
    assert "Comparing" in html_compare.beside(None)
    jobs.begin(begin)
    state = ended(jobs, begin)
    told = state.latest
    page = html_compare.beside(state)
    assert f"part in {len(told.episode.disagreements)} of {len(one.episodes[0])} steps" in page
    assert "All settings are the same" in html_compare.settings(told.settings)
    decision = one.episodes[0].decisions[0]
    evil = html_compare.at_this_step(
        decision, replace(decision, action=1 - decision.action), hostile_spec()
    )
    assert "they part here" in evil
    assert EVIL not in evil
    assert "<img" not in evil


def test_the_shelf_knows_the_task_of_every_file_without_opening_it(tmp_path, agents):
    agents[0].save(tmp_path / "mine.ao2")
    (tmp_path / "broken.ao2").write_bytes(b"no agent")
    library = Library(tmp_path, tmp_path)
    known = {item.label: item.env_id for item in library.shelf()}
    library.close()
    assert known == {"mine": "CartPole-v1", "broken": ""}
