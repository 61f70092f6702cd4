"""The replay's commands: moments, conditions, loops, branches; plain functions, no server."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.training.branching import Takeover
from ao2viz.training.states import RunStatus
from ao2viz.training.updates import RunUpdate
from ao2viz.ui import html_replay
from ao2viz.ui.branches import BranchFailure, BranchUnderWay
from ao2viz.ui.commands import ChooseEpisode, ChooseSource, Command, Seek
from ao2viz.ui.reduce import advance, follow, reduce
from ao2viz.ui.replay_commands import (
    CancelBranch,
    LimitBranch,
    Rejoin,
    SeekMoment,
    SeekStop,
    SetLoop,
    SetStop,
    ShowMoment,
    TakeOver,
)
from ao2viz.ui.session import Session, Wanted
from ao2viz.ui.view import project
from ao2viz.ui.world import LoadFailure, World
from tests.ui.test_reduce import FILE, after, episode, watching, world


def turning(*chosen: int) -> World:
    """A world whose first episode took these actions."""
    taken = world()
    agent = taken.opened[FILE]
    made = episode(len(chosen), actions=np.array(chosen))
    return replace(taken, opened={FILE: replace(agent, episodes=(made, episode(4)))})  # pyright: ignore


def test_playing_holds_at_the_first_step_that_meets_the_condition():
    acts = turning(1, 1, 0, 1, 1, 1, 0, 1)
    session = after(watching(0.0, is_playing=True), SetStop("action = left"), acts)
    held = advance(session, acts, 0.5)
    assert (held.position, held.is_playing) == (2.0, False)
    assert held.remark == "Held at step 2: action = left."
    on = advance(replace(held, is_playing=True), acts, 0.3)
    assert on.is_playing  # It does not hold twice at the same step.
    assert advance(replace(on, play_speed=8.0), acts, 1.0).position == 6.0


@given(
    st.lists(st.integers(0, 1), min_size=1, max_size=40),
    st.lists(st.floats(0, 0.4), min_size=1, max_size=40),
    st.sampled_from([0.125, 1.0, 8.0]),
)
@settings(deadline=None)
def test_however_fast_it_plays_no_stop_is_passed(actions, ticks, speed):
    acts = turning(*actions)
    session = after(
        watching(0.0, is_playing=True, play_speed=speed), SetStop("action = left"), acts
    )
    for tick in ticks:
        before = session
        session = advance(session, acts, tick)
        passed = range(int(before.position) + 1, int(session.position))
        assert not any(actions[t] == 0 for t in passed)
        if not session.is_playing:
            break


def test_next_and_previous_stop_search_both_ways_and_say_when_there_is_none():
    acts = turning(1, 0, 1, 1, 0, 1)
    session = after(watching(2.0), SetStop("action = left"), acts)
    assert after(session, SeekStop(True), acts).position == 4
    assert after(session, SeekStop(False), acts).position == 1
    none = after(replace(session, position=4.0), SeekStop(True), acts)
    assert none.position == 4
    assert none.remark == "There is no step with action = left after step 4."
    assert "Type a condition" in after(watching(), SeekStop(True), acts).remark
    assert after(none, Seek(1), acts).remark == ""


def test_bad_text_says_why_and_changes_nothing():
    session = after(watching(3.0), SetStop("margin < 0.1"))
    bad = after(session, SetStop("margin < banana"))
    assert bad == replace(session, stop_problem=bad.stop_problem)
    assert "At character 10: expected a number" in bad.stop_problem
    assert after(bad, SetStop("")).stop_problem == ""
    page = html_replay.stops(project(replace(bad, stop_problem="<img>"), world()))
    assert "&lt;img&gt;" in page


def test_moments_are_gone_to_one_by_one():
    session, seen = watching(0.0), []
    for _ in range(20):
        session = after(session, SeekMoment(True))
        seen.append(session.position)
        if session.remark:
            break
    listed = {m.step for m in project(watching(), world()).replay.moments}
    assert set(seen) | {0.0} == listed | {0.0}
    assert session.remark == "There is no moment of note after step 10."
    assert after(session, SeekMoment(False)).position < 10


def test_a_loop_shows_the_end_and_begins_anew():
    session = after(watching(9.0, is_playing=True), SetLoop(None))
    assert session.loops
    ended = advance(session, world(), 1.0)
    assert (ended.position, ended.is_playing) == (10, True)
    assert advance(ended, world(), 0.05).position == 0
    held = advance(after(session, SetLoop(False)), world(), 1.0)
    assert (held.position, held.is_playing) == (10, False)


def branched(session: Session, made=None) -> tuple[Session, World]:
    """The session once its wish has been played, and a world that says so."""
    assert session.wish is not None
    result = episode(6, actions=np.zeros(6, np.int64)) if made is None else made
    done = replace(world(), branched={session.wish: result})
    return advance(session, done, 0.0), done


def test_taking_over_wishes_for_a_branch_and_shows_it_at_that_step():
    asked = after(watching(4.0, branch_limit=7), TakeOver(0))
    assert asked.wish is not None
    assert asked.wish.takeovers == (Takeover(4, 0),)
    assert (asked.wish.limit, asked.is_playing) == (7, False)
    under_way = replace(world(), branched={asked.wish: BranchUnderWay(3)})
    assert advance(asked, under_way, 1.0).wish is asked.wish
    assert "3 steps so far" in html_replay.line(project(asked, under_way))
    session, done = branched(asked)
    view = project(session, done)
    assert (view.transport.position, view.transport.last) == (4, 6)
    assert session.branch is not None
    assert view.episode is session.branch.episode
    assert "Branch from step 4: you chose push left." in html_replay.line(view)
    assert "main line" in html_replay.branch_facts(view)
    assert "You chose push left here" in html_replay.taken_over(view)
    assert html_replay.taken_over(project(replace(session, position=5.0), done)) == ""


def test_a_branch_leads_back_to_where_it_began():
    session, _ = branched(after(watching(4.0), TakeOver(0)))
    back = after(replace(session, position=6.0), Rejoin())
    assert (back.branch, back.position, back.is_playing) == (None, 4.0, False)
    assert after(watching(2.0), Rejoin()).position == 2.0


def test_taking_over_again_keeps_what_was_chosen_before_that_step():
    session, _ = branched(after(watching(2.0), TakeOver(0)))
    main = session.branch.main  # pyright: ignore[reportOptionalMemberAccess]
    again = after(replace(session, position=5.0), TakeOver(1))
    assert again.wish is not None
    assert again.wish.main is main
    assert again.wish.takeovers == (Takeover(2, 0), Takeover(5, 1))
    earlier = after(replace(session, position=1.0), TakeOver(1))
    assert earlier.wish is not None
    assert earlier.wish.takeovers == (Takeover(1, 1),)
    same = after(replace(session, position=2.0), TakeOver(1))
    assert same.wish is not None
    assert same.wish.takeovers == (Takeover(2, 1),)


def test_a_branch_that_fails_or_is_called_off_changes_nothing_but_says_so():
    asked = after(watching(4.0), TakeOver(0))
    failed, _ = branched(asked, BranchFailure("It no longer repeats."))
    assert (failed.branch, failed.wish, failed.position) == (None, None, 4.0)
    assert failed.remark == "It no longer repeats."
    assert after(asked, CancelBranch()).wish is None


@pytest.mark.parametrize(
    ("session", "action", "words"),
    [
        (watching(10.0), 0, "has ended here"),
        (watching(1.0), 2, "no action 2"),
        (watching(1.0), -1, "no action -1"),
        (Session(source=None), 0, "Pause first"),
    ],
)
def test_nobody_takes_over_where_there_is_nothing_to_do(session, action, words):
    refused = after(session, TakeOver(action))
    assert refused.wish is None
    assert words in refused.remark


def test_how_far_the_agent_goes_on_is_bounded():
    assert after(watching(), LimitBranch(10**9)).branch_limit == 10_000
    assert after(watching(), LimitBranch(-4)).branch_limit == 0


@pytest.mark.parametrize(
    "command", [ChooseEpisode(1), ChooseSource(Path("/agents/two.ao2")), ShowMoment(1, 2)]
)
def test_going_elsewhere_leaves_the_branch(command: Command):
    session, _ = branched(after(watching(4.0), TakeOver(0)))
    left = after(session, command)
    assert (left.branch, left.wish) == (None, None)


def test_a_run_that_goes_on_leaves_the_branch():
    held = RunUpdate(RunStatus.PAUSED, episode=episode(5))
    session, _ = branched(after(watching(4.0), TakeOver(0)))
    assert follow(replace(session, source=None), held, RunUpdate()).branch is None


def test_what_an_address_asked_for_is_shown_once_the_file_is_open():
    wished = Session(source=FILE, wanted=Wanted(1, 3))
    closed = replace(world(), opened={})
    assert advance(wished, closed, 1.0).wanted == Wanted(1, 3)
    there = advance(wished, world(), 1.0)
    assert (there.episode, there.position, there.is_playing) == (1, 3.0, False)
    assert there.wanted is None
    plays = advance(Session(source=FILE, wanted=Wanted(1)), world(), 0.0)
    assert (plays.episode, plays.is_playing) == (1, True)
    broken = replace(world(), opened={FILE: LoadFailure("no")})
    assert advance(wished, broken, 1.0).wanted is None


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        (Wanted(9, 0), "You asked for episode 9, but this agent has only episodes 0 to 1, counted"),
        (Wanted(1, 999), "You asked for step 999, but this episode has 4 steps."),
    ],
)
def test_a_moment_that_is_not_there_is_said(wanted, words):
    there = advance(Session(source=FILE, wanted=wanted), world(), 1.0)
    assert there.remark.startswith(words)
    assert words in html_replay.line(project(there, world()))


def test_a_stop_typed_for_another_task_stops_nothing():
    odd = replace(watching(0.0, is_playing=True), stop_text="torque > 1")
    assert advance(odd, world(), 5.0).position == 10
    assert reduce(odd, SeekStop(True), world())[0].position == 0
