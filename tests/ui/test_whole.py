"""The agent as a whole on the page: counted beside it, ended, kept, told in words, gone to."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.envs.catalogue import Feature
from ao2viz.explain.agreement import tell_faithfulness
from ao2viz.explain.whole import Attended, moment_of
from ao2viz.explain.whole_telling import tell_coverage, tell_roles
from ao2viz.store.saved import SavedAgent
from ao2viz.training.states import RunStatus
from ao2viz.training.updates import RunUpdate
from ao2viz.ui import html_whole
from ao2viz.ui.downloads import Notify
from ao2viz.ui.jobs import Begin, Jobs, JobState
from ao2viz.ui.questions import (
    ChooseMuted,
    ChooseMutedEpisodes,
    LookAtWhole,
    Mute,
    Task,
)
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session
from ao2viz.ui.view import project
from ao2viz.ui.whole import (
    MOST_EPISODES,
    MOST_MUTED,
    Kept,
    Playing,
    Portrait,
    Whole,
    whole_of,
)
from ao2viz.ui.world import World
from tests.forests import cartpole
from tests.ui.agents import saved_agent

FILE, OTHER = Path("here.ao2"), Path("<b>there.ao2")
EVIL = "<img src=x onerror=alert(1)>\"'&"
LOOKING = Session(source=FILE)


@pytest.fixture(scope="module")
def agent() -> AO2:
    trained = AO2("CartPole-v1", seed=0, warmup_steps=50, levels=1).learn(400)
    trained.record_episode(1)
    trained.record_episode(2)
    return trained


def world_of(saved: SavedAgent) -> World:
    return World(opened={FILE: saved})


def begun(session: Session, command: LookAtWhole | Mute, world: World) -> Begin:
    _, (begin,) = reduce(session, command, world)
    assert isinstance(begin, Begin)
    return begin


def wait(look: Callable[[], JobState | None], is_enough: Callable[[JobState], bool]) -> JobState:
    deadline = time.monotonic() + 60
    while True:
        state = look()
        if state is not None and is_enough(state):
            return state
        assert time.monotonic() < deadline, "It never came to that."
        time.sleep(0.005)


def test_all_is_counted_beside_the_page_as_the_agent_itself_tells_it(agent: AO2) -> None:
    world = world_of(agent.to_saved())
    jobs, kept, about = Jobs(), Kept(), whole_of(LOOKING, world).subject
    session, (begin,) = reduce(LOOKING, LookAtWhole(begins=True), world)
    assert session.looks_at_whole == LOOKING.looks_at_whole + 1
    jobs.begin(begin)
    job = wait(lambda: kept.look(jobs, Task.WHOLE, about), lambda state: state.is_done)
    portrait, overview = job.latest, agent.explain.whole.overview()
    assert isinstance(portrait, Portrait)
    assert (portrait.is_complete, portrait.share, html_whole.progress(job)) == (True, 1.0, "")
    np.testing.assert_array_equal(portrait.attention.shares, overview.attention.shares)
    np.testing.assert_array_equal(portrait.roles.deciding, overview.roles.deciding)
    assert portrait.highlights == overview.highlights
    assert portrait.faithfulness == overview.faithfulness
    # In the words of the command line.
    assert html_whole.roles(portrait).count(tell_roles(overview.roles)) == 1
    assert html_whole.coverage(portrait).count(tell_coverage(overview.coverage)) == 1
    assert html_whole.faithfulness(portrait).count(tell_faithfulness(overview.faithfulness)) == 1
    page = html_whole.attention(portrait, agent.spec)
    order = np.argsort(-overview.attention.shares)
    names = [f"<td>{agent.spec.features[d].name}</td>" for d in order]
    assert [page.index(name) for name in names] == sorted(page.index(name) for name in names)
    for share in (*overview.attention.shares, *overview.attention.runner_up_shares):
        assert f"{100 * share:.0f} %" in page
        assert f"width:{100 * share:.0f}%" in page


def test_what_was_known_when_it_was_ended_stays_and_so_does_what_was_left(agent: AO2) -> None:
    world = World(opened={FILE: agent.to_saved(), OTHER: saved_agent()})
    about, others = (whole_of(Session(source=path), world).subject for path in (FILE, OTHER))
    jobs, kept = Jobs(), Kept()
    begin = begun(LOOKING, LookAtWhole(begins=True), world)
    ended = begin.work(lambda portrait: portrait.roles is None)
    assert not ended.is_complete
    assert ended.roles.states == len(agent.explain.whole.states())
    assert ended.faithfulness is None
    job = JobState(ended, True, "", 1.0)
    assert "Ended before all was counted" in html_whole.progress(job)
    under_way = replace(job, is_done=False)
    assert f"Counting faithfulness, {100 * ended.share:.0f} %, 1 s …" in html_whole.progress(
        under_way
    )
    without_roles = replace(under_way, latest=replace(ended, roles=None, share=0.1))
    assert "Counting roles, 10 %" in html_whole.progress(without_roles)
    assert "Getting the agent ready" in html_whole.progress(replace(under_way, latest=None))
    assert html_whole.faithfulness(ended) == ""
    at_once = begin.work(lambda _: False)
    assert at_once.roles.states == 0
    assert html_whole.roles(at_once) == ""
    assert at_once.attention is not None
    jobs.begin(begin)
    wait(lambda: kept.look(jobs, Task.WHOLE, about), lambda state: state.latest is not None)
    # Another agent is another subject; coming back shows what there was, and counts nothing.
    assert kept.look(jobs, Task.WHOLE, others) is None
    assert jobs.look(Task.WHOLE, about) is None
    again = kept.look(jobs, Task.WHOLE, about)
    assert again.is_done
    assert again.latest.attention is not None


def test_options_are_muted_as_the_agent_itself_does_it(agent: AO2) -> None:
    world = world_of(agent.to_saved())
    session = replace(LOOKING, muted_episodes=2)
    options = agent.explain.whole.roles().deciding[:2].tolist()
    begin, states = begun(session, Mute((*options, -1, 10**9)), world), []
    done = begin.work(lambda playing: bool(states.append(playing)) or True)
    expected = agent.explain.whole.carriers(options, episodes=2)
    assert done.told == expected
    assert (done.played, done.planned) == (6, 6)
    assert sorted({state.played for state in states}) == [1, 2, 3, 4, 5, 6]
    page = html_whole.carriers(JobState(done, True, "", 1.0))
    assert f"With all options: {expected.mean_return:.3g}" in page
    assert tell_faithfulness(expected.faithfulness) in page
    words = [html_whole.muted_words(one) for one in done.told.muted]
    assert all(
        word.startswith(f"Option {option}: a loss of")
        for word, option in zip(words, [one.option for one in expected.muted], strict=True)
    )
    early = begin.work(lambda playing: playing.played < 5)
    assert [one.option for one in early.told.muted] == options[:1]
    page = html_whole.carriers(JobState(early, True, "", 1.0))
    assert "Ended: 5 of 6 episodes played. What is known so far stands below." in page
    busy = html_whole.carriers(JobState(Playing(3, 6, None), False, "", 1.0))
    assert "3 of 6 episodes played, 1 s …" in busy
    assert html_whole.share_of(JobState(Playing(3, 6, None), False, "", 1.0)) == 0.5


def test_of_an_environment_that_is_not_there_all_but_playing_is_told(agent: AO2) -> None:
    saved = agent.to_saved()
    gone = replace(saved, spec=replace(saved.spec, env_id="Nowhere-v9"))
    world, jobs = world_of(gone), Jobs()
    assert begun(LOOKING, LookAtWhole(begins=True), world).work(lambda _: True).is_complete
    begin = begun(LOOKING, Mute((0,)), world)
    jobs.begin(begin)
    job = wait(lambda: jobs.look(Task.MUTE, begin.about), lambda state: state.is_done)
    page = html_whole.carriers(job)
    assert "This cannot be played here. Could not make the environment" in page
    assert "Nowhere-v9" in page


def test_nothing_is_asked_while_it_learns_or_where_there_is_nothing(agent: AO2) -> None:
    nothing = World()
    learning = World(update=RunUpdate(RunStatus.RUNNING, spec=cartpole()))
    for session, world, words in (
        (Session(), nothing, "There is no agent yet"),
        (Session(), learning, "Pause the run to look at it as a whole"),
        (LOOKING, nothing, "Opening here.ao2"),
    ):
        whole = whole_of(session, world)
        assert (whole.subject, words in whole.problem) == ((), True)
        assert words in html_whole.heading(whole)
        for command in (LookAtWhole(begins=True), Mute((0,))):
            _, (effect,) = reduce(session, command, world)
            assert isinstance(effect, Notify)
            assert words in effect.body
    shown, effects = reduce(Session(), LookAtWhole(begins=False), nothing)
    assert (shown.looks_at_whole, effects) == (1, ())
    _, (effect,) = reduce(LOOKING, Mute(()), world_of(agent.to_saved()))
    assert isinstance(effect, Notify)
    assert "it tells which options decide" in effect.body


def test_the_page_says_over_what_it_counts_and_of_whom() -> None:
    recorded = Whole((1,), "", 300, True, "", 5, 10, 0)
    assert "Counted over 300 recorded states.</p>" in html_whole.heading(recorded)
    many = html_whole.heading(replace(recorded, states=1_000))
    assert "1,000 recorded states. Where each takes many decisions, 400 of them" in many
    huge = html_whole.heading(replace(recorded, states=1_000_000, are_recorded=False))
    assert "1,000,000 options. Of them 20,000 are taken, evenly spread, and 400" in huge
    assert "No decision is recorded" in huge
    beside = html_whole.heading(replace(recorded, beside=OTHER.stem))
    assert "not of “&lt;b&gt;there” beside it" in beside
    world = world_of(saved_agent())
    assert whole_of(LOOKING, world).beside == ""
    assert whole_of(replace(LOOKING, other=OTHER), world).beside == OTHER.stem
    assert (whole_of(LOOKING, world).states, whole_of(LOOKING, world).are_recorded) == (5, False)


def test_without_recorded_decisions_only_runner_ups_are_at_a_distance() -> None:
    world = world_of(saved_agent())
    portrait = begun(LOOKING, LookAtWhole(begins=True), world).work(lambda _: True)
    assert portrait.attention.states == 0
    page = html_whole.attention(portrait, cartpole())
    assert "every state is an option's value" in page
    assert page.count("–</td>") == 4
    assert "tried at 5 options" in html_whole.faithfulness(portrait)
    assert portrait.highlights == ()
    assert moment_of(portrait.coverage.farthest, ()) is None


def test_nothing_from_a_file_becomes_html() -> None:
    spec = replace(cartpole(), features=tuple(Feature(EVIL, EVIL) for _ in range(4)))
    shares = np.full(4, 0.25)
    pages = [
        html_whole.attention(Portrait(attention=Attended(shares, shares, 3)), spec),
        html_whole.heading(Whole((), EVIL, 1, True, "", 5, 10, 0)),
        html_whole.heading(Whole((1,), "", 1, True, EVIL, 5, 10, 0)),
        html_whole.progress(JobState(None, True, EVIL, 0.0)),
        html_whole.carriers(JobState(None, True, EVIL, 0.0)),
    ]
    for page in pages:
        assert "<img" not in page
        assert "&lt;img" in page


def test_of_very_many_features_the_least_are_told_as_one() -> None:
    spec = replace(cartpole(), features=tuple(Feature(f"pixel {d}", "") for d in range(100)))
    shares = np.arange(100) / np.arange(100).sum()
    page = html_whole.attention(Portrait(attention=Attended(shares, shares[::-1], 9)), spec)
    assert page.count("<tr>") == 1 + 20 + 1
    assert "pixel 99" in page
    assert "<td>80 more</td>" in page
    assert f"{100 * shares[:80].sum():.0f} %" in page


def test_a_place_among_all_recorded_states_is_a_step_of_an_episode(agent: AO2) -> None:
    episodes = agent.episodes
    states = agent.explain.whole.states()
    for place in (0, len(episodes[0]) - 1, len(episodes[0]), len(states) - 1):
        number, step = moment_of(place, episodes)
        np.testing.assert_array_equal(episodes[number].observations[step], states[place])
    assert moment_of(len(states), episodes) is None


@pytest.mark.parametrize("number", [-(2**40), 0, 3, 2**40])
def test_fields_take_what_can_be_played(number: int) -> None:
    world = World()
    session, _ = reduce(LOOKING, ChooseMuted(number), world)
    session, _ = reduce(session, ChooseMutedEpisodes(number), world)
    whole = project(session, world).whole
    assert 1 <= whole.options <= MOST_MUTED
    assert 1 <= whole.episodes <= MOST_EPISODES
    if number == 3:
        assert (whole.options, whole.episodes) == (3, 3)
