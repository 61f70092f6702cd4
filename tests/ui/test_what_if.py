"""What if: states that a person supposes, what is asked of them, and long work beside."""

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import viser
from hypothesis import given
from hypothesis import strategies as st

from ao2viz.agent import AO2
from ao2viz.envs.ranges import Ranges, ranges_by_id, unlimited
from ao2viz.explain.flips import Flips
from ao2viz.training.states import RunStatus
from ao2viz.training.updates import RunUpdate
from ao2viz.ui import html_what_if
from ao2viz.ui.commands import ChooseSource, Move, Transport
from ao2viz.ui.dials import make_dials
from ao2viz.ui.downloads import Notify
from ao2viz.ui.jobs import Begin, Jobs
from ao2viz.ui.mirror import Mirror
from ao2viz.ui.questions import CallOff, FindNearest, StopSupposing, Suppose, SupposeState, Task
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session
from ao2viz.ui.supposing import STILL_S, Supposing, why_nothing
from ao2viz.ui.thinker import NoAnswer, Thinker
from ao2viz.ui.view import project
from ao2viz.ui.world import World
from tests.forests import cartpole, small_view
from tests.ui.test_reduce import FILE, after, watching, world

SOURCE = FILE


@pytest.fixture(scope="module")
def agent() -> AO2:
    trained = AO2("CartPole-v1", seed=0, warmup_steps=100, levels=2).learn(600)
    trained.record_episode(5)
    return trained


@pytest.fixture
def thinker() -> Iterator[Thinker]:
    made = Thinker()
    yield made
    made.close()


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def settled(look: Callable[[], Any], is_enough: Callable[[Any], bool]) -> Any:
    deadline = time.monotonic() + 60
    while not is_enough(found := look()):
        assert time.monotonic() < deadline, "No answer came."
        time.sleep(0.01)
    return found


def supposed_of(session: Session, w: World | None = None):
    return project(session, w or world()).supposed


def test_a_supposed_feature_changes_that_one_alone_and_holds_the_replay():
    session = after(replace(watching(3), is_playing=True), Suppose(2, 0.1))
    seen = project(session, world()).observation
    assert not session.is_playing
    assert supposed_of(session).tolist() == [seen[0], seen[1], 0.1, seen[3]]
    session = after(session, Suppose(0, -1.0))
    assert supposed_of(session).tolist() == [-1.0, seen[1], 0.1, seen[3]]
    assert supposed_of(after(session, StopSupposing())) is None


def test_a_supposition_belongs_to_its_moment():
    w = world()
    episode = w.opened[FILE].episodes[0]
    decisions = tuple(
        replace(one, observation=one.observation + n) for n, one in enumerate(episode.decisions)
    )
    agent = replace(w.opened[FILE], episodes=(replace(episode, decisions=decisions),))
    w = replace(w, opened={FILE: agent})
    session = after(watching(3), Suppose(2, 0.1), w)
    assert supposed_of(session, w) is not None
    assert supposed_of(after(session, Move(Transport.FORWARD), w), w) is None
    assert supposed_of(after(session, ChooseSource(None), w), w) is None
    back = after(after(session, Move(Transport.FORWARD), w), Move(Transport.BACK), w)
    assert supposed_of(back, w) is not None


@pytest.mark.parametrize(
    "command",
    [
        Suppose(0, float("nan")),
        Suppose(0, float("inf")),
        SupposeState((0.0, 0.0)),
        SupposeState((0.0, 0.0, float("nan"), 0.0)),
    ],
)
def test_what_is_no_state_is_refused_in_words(command):
    session, effects = reduce(watching(3), command, world())
    assert session.supposition is None
    assert isinstance(effects[0], Notify)
    assert "4 finite numbers" in effects[0].body


def test_while_a_run_goes_on_nobody_supposes():
    running = world(RunUpdate(status=RunStatus.RUNNING, forest=small_view(), spec=cartpole()))
    session, effects = reduce(Session(source=None), Suppose(0, 1.0), running)
    assert session.supposition is None
    assert "hold the run" in effects[0].body


def test_the_search_for_the_nearest_flip_is_about_what_is_supposed():
    session = after(watching(3), Suppose(2, 0.1))
    _, effects = reduce(session, FindNearest(), world())
    begin = effects[0]
    assert isinstance(begin, Begin)
    assert begin.task is Task.NEAREST
    assert begin.about[1] == supposed_of(session).tobytes()
    assert reduce(session, CallOff(Task.NEAREST), world())[1] == (CallOff(Task.NEAREST),)


@given(st.floats(-1e3, 1e3), st.floats(0.01, 1e3), st.floats(-2, 2))
def test_a_control_stays_within_what_the_environment_allows(low, size, at):
    ranges = Ranges(np.full(4, low), np.full(4, low + size))
    spec = cartpole()
    for feature, dial in zip(spec.features, make_dials(small_view(), ranges, spec), strict=True):
        ends = np.array([low, low + size]) * feature.scale
        slack = 1e-6 * dial.step + 1e-9 * np.abs(ends).max()
        assert ends[0] - slack <= dial.low <= dial.high <= ends[1] + slack
        shown = (low + (at + 2) / 4 * size) * feature.scale
        place = dial.nearest(shown)
        assert dial.low <= place <= dial.high
        assert abs(place - shown) <= dial.step * 1.01


def test_where_there_are_no_bounds_a_control_holds_all_options():
    view, spec = small_view(), cartpole()
    dials = make_dials(view, unlimited(4), spec)
    shown = view.values[view.is_alive] * [f.scale for f in spec.features]
    for d, dial in enumerate(dials):
        assert dial.low < shown[:, d].min() <= shown[:, d].max() < dial.high
        # Enough steps to find a place, few enough to be told apart.
        assert 300 < (dial.high - dial.low) / dial.step < 1200


def test_ranges_are_those_of_the_environment_or_none():
    assert ranges_by_id("CartPole-v1", 4).high[0] == pytest.approx(4.8)
    assert np.isinf(ranges_by_id("NoSuchEnv-v7", 4).high).all()
    assert np.isinf(ranges_by_id("CartPole-v1", 3).high).all()


def file_of(agent: AO2) -> tuple[Session, World]:
    saved = agent.to_saved()
    session = Session(source=SOURCE, position=2.0, is_playing=False)
    return session, World(opened={SOURCE: saved})


def test_what_is_supposed_is_answered_as_the_agent_itself_would(agent, thinker):
    session, w = file_of(agent)
    session = after(session, Suppose(3, 1.5), w)
    view, clock = project(session, w), Clock()
    supposing = Supposing(clock)
    first = settled(lambda: supposing.ask(view, thinker), lambda a: a and a.decision)
    assert first.is_supposed
    expected = agent.decide(view.supposed)
    assert first.decision.action == expected.action
    assert first.decision.path.tolist() == expected.path.tolist()
    settled(lambda: supposing.ask(view, thinker), lambda a: a.ahead)
    assert supposing.ask(view, thinker).flips is None, "It moved a moment ago."
    clock.now = STILL_S
    answer = settled(lambda: supposing.ask(view, thinker), lambda a: a.flips)
    assert isinstance(answer.flips, Flips)
    for both in answer.flips.features:
        for flip in (both.less, both.more):
            if flip is not None:
                there = view.supposed.copy()
                there[flip.feature] = flip.beyond
                assert agent.decide(there).action == flip.action != expected.action
    answer = settled(lambda: supposing.ask(view, thinker), lambda a: a.faithfulness)
    assert answer.faithfulness.flips.agreed == answer.faithfulness.flips.tried > 0
    assert supposing.ask(view, thinker) is answer, "Nothing more is to be known."


def test_a_control_that_moves_on_leaves_no_old_questions_waiting(agent, thinker):
    session, w = file_of(agent)
    gate = threading.Event()
    learned = w.opened[SOURCE].learned
    assert thinker._ask("busy", learned, lambda _: gate.wait(30)) is None
    supposing = Supposing(Clock())
    thinker.ranges(learned, w.opened[SOURCE].spec)
    for n in range(50):
        view = project(after(session, Suppose(3, n / 50), w), w)
        supposing._dials = learned, make_dials(view.forest, unlimited(4), view.spec)
        supposing.ask(view, thinker)
    waiting = [f for _, f in thinker._asked.values() if not f.done()]
    assert len(waiting) <= 4  # One under way, three wait.
    gate.set()
    answer = settled(lambda: supposing.ask(view, thinker), lambda a: a and a.decision)
    assert answer.decision.observation.tolist() == view.supposed.tolist()


def test_without_an_answer_it_says_whether_to_wait_or_what_to_do(agent, thinker, monkeypatch):
    session, w = file_of(agent)
    supposing, view = Supposing(Clock()), project(session, w)
    gate = threading.Event()
    learned = w.opened[SOURCE].learned
    assert thinker._ask("busy", learned, lambda _: gate.wait(30)) is None
    assert "some seconds" in why_nothing(view, supposing.ask(view, thinker))
    running = replace(view, learned=None)
    assert "hold the run" in why_nothing(running, supposing.ask(running, thinker))

    def fail(env_id, n_features):
        raise ValueError("There is no such environment.")

    monkeypatch.setattr("ao2viz.ui.thinker.ranges_by_id", fail)
    gate.set()
    asked = settled(lambda: supposing.ask(view, thinker), lambda a: a is not None)
    assert "There is no such environment." in why_nothing(view, asked)


def test_an_episode_that_plays_asks_nothing_of_each_step(agent, thinker):
    session, w = file_of(agent)
    view = project(replace(session, is_playing=True), w)
    supposing = Supposing(Clock())
    answer = settled(lambda: supposing.ask(view, thinker), lambda a: a is not None)
    assert answer.decision is None
    assert not any("decision" in key for key in thinker._asked)


def test_an_agent_that_thinks_ahead_says_why_it_is_not_asked_for_flips(agent, thinker):
    saved = agent.to_saved()
    thoughtful = replace(saved, config=replace(saved.config, think_ahead=20))
    seen = saved.episodes[0].observations[0]
    answer = settled(
        lambda: thinker.flips(thoughtful.learned, saved.spec, seen), lambda a: a is not None
    )
    assert isinstance(answer, NoAnswer)
    assert "ao2viz explain" in answer.words


def test_work_tells_how_far_it_is_and_ends_when_called_off():
    jobs, go_on = Jobs(), threading.Event()

    def work(report):
        n = 0
        while report(n):
            n += 1
            go_on.wait(0.01)
        return n

    jobs.begin(Begin(Task.NEAREST, ("here",), work))
    state = settled(lambda: jobs.look(Task.NEAREST, ("here",)), lambda s: (s.latest or 0) > 2)
    assert not state.is_done
    jobs.call_off(Task.NEAREST)
    state = settled(lambda: jobs.look(Task.NEAREST, ("here",)), lambda s: s.is_done)
    assert state.latest > 2
    assert state.error == ""
    assert jobs.look(Task.NEAREST, ("here",)) is state


def test_work_about_something_else_is_called_off_and_forgotten():
    jobs, ended = Jobs(), threading.Event()

    def work(report):
        while report(0):
            time.sleep(0.01)
        ended.set()
        return 0

    jobs.begin(Begin(Task.NEAREST, ("here",), work))
    assert jobs.look(Task.NEAREST, ("there",)) is None
    assert ended.wait(10)
    assert jobs.look(Task.NEAREST, ("here",)) is None


@pytest.mark.parametrize(
    ("error", "words"),
    [(ValueError("It votes."), "It votes."), (KeyError("x"), "KeyError: 'x'")],
)
def test_work_that_fails_says_so(error, words):
    jobs = Jobs()

    def work(report):
        raise error

    jobs.begin(Begin(Task.NEAREST, (), work))
    state = settled(lambda: jobs.look(Task.NEAREST, ()), lambda s: s.is_done)
    assert state.error == words
    assert state.latest is None
    assert words.replace("'", "&#x27;") in html_what_if.nearest(state, cartpole())


def test_a_search_gives_a_flip_that_flips(agent):
    session, w = file_of(agent)
    _, effects = reduce(session, FindNearest(), w)
    jobs = Jobs()
    jobs.begin(effects[0])
    state = settled(lambda: jobs.look(Task.NEAREST, effects[0].about), lambda s: s.is_done)
    assert state.error == ""
    seen = project(session, w).observation
    assert agent.decide(state.latest.flipped).action != agent.decide(seen).action
    page = html_what_if.nearest(state, cartpole())
    assert "then it chooses" in page


@pytest.fixture
def slider() -> Iterator[viser.GuiSliderHandle]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server.gui.add_slider("x", 0.0, 10.0, 0.1, 0.0)
    server.stop()


def test_a_control_that_a_person_moves_is_not_pulled_back(slider):
    mirror = Mirror(slider)
    mirror.settle(0.0)
    slider._impl.value = 3.0  # As viser does when a person moves it.
    mirror.settle(0.0)
    assert slider.value == 3.0, "The command is still on its way."
    slider._impl.value = 4.0
    mirror.settle(3.0)
    assert slider.value == 4.0, "The next one is, too."
    mirror.settle(4.0)
    mirror.settle(0.0)
    assert slider.value == 0.0, "Reset."


def test_a_control_whose_change_was_refused_goes_back(slider):
    mirror = Mirror(slider)
    slider._impl.value = 3.0
    mirror.settle(0.0)
    mirror.settle(0.0)
    assert slider.value == 0.0
