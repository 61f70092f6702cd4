"""Where weights come from, where decisions lead, and the way back: the inspector's logic."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from ao2viz.agent import AO2
from ao2viz.core.decision import NO_OPTION
from ao2viz.envs.catalogue import Feature
from ao2viz.explain.ahead import AheadEnd, look_ahead
from ao2viz.explain.origin import Origin
from ao2viz.explain.uses import Use, find_uses
from ao2viz.layout.discs import lay_out
from ao2viz.layout.state_space import fit_axes
from ao2viz.ui import html_reasons
from ao2viz.ui.camera import Lens
from ao2viz.ui.commands import (
    GoBack,
    GoForward,
    OpenWeight,
    Select,
    ShowAhead,
    Walk,
    Way,
)
from ao2viz.ui.lettering import choose_sides
from ao2viz.ui.look import Arrangement, Look
from ao2viz.ui.overlay import Moment, overlay
from ao2viz.ui.picture import draw
from ao2viz.ui.replay_commands import ShowMoment
from ao2viz.ui.session import Session
from ao2viz.ui.thinker import NoAnswer, Thinker
from ao2viz.ui.view import project
from tests.forests import decision
from tests.ui.test_reduce import after, episode, watching, world

EVIL = "<img src=x onerror=alert(1)>\"'&"


@pytest.fixture(scope="module")
def agent() -> AO2:
    trained = AO2("CartPole-v1", seed=0, warmup_steps=60).learn(700)
    trained.record_episode(3)
    return trained


@pytest.fixture(scope="module")
def saved(agent):
    return agent.to_saved()


@pytest.fixture
def thinker():
    made = Thinker()
    yield made
    made.close()


def answer_of(ask):
    deadline = time.monotonic() + 60
    while (answer := ask()) is None:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return answer


def inspected(session: Session) -> tuple[int, int | None]:
    return session.selected, session.opened


def test_the_way_back_and_forward_is_that_of_a_browser():
    session = watching()
    for command in (Select(4), OpenWeight(1), Select(2)):
        session = after(session, command)
    assert inspected(session) == (2, None)
    session = after(session, GoBack())
    assert inspected(session) == (4, 1)
    session = after(after(session, GoBack()), GoBack())
    assert inspected(session) == (4, None)  # There the way begins.
    assert not project(session, world()).can_go_back
    session = after(session, GoForward())
    assert inspected(session) == (4, 1)
    assert project(session, world()).can_go_forward
    elsewhere = after(session, Select(1))
    assert not project(elsewhere, world()).can_go_forward  # Another way was taken.
    assert inspected(after(elsewhere, GoBack())) == (4, 1)


def test_selecting_the_same_again_is_no_step():
    session = after(after(watching(), Select(4)), Select(4))
    assert len(session.trail) == 1
    assert len(after(session, Walk(Way.CHILD)).trail) == 1  # It has no child.
    assert after(session, Select(NO_OPTION)).opened is None


def test_the_trail_is_not_kept_for_ever():
    session = watching()
    for _ in range(80):
        session = after(after(session, Select(1)), Select(2))
    assert len(session.trail) == 100
    assert session.trail[session.trail_at].option == 2


def test_a_weight_is_opened_only_where_there_is_one():
    assert after(watching(selected=4), OpenWeight(1)).opened == 1
    assert after(watching(selected=4), OpenWeight(9)).opened is None
    assert after(watching(), OpenWeight(0)).opened is None
    assert after(after(watching(selected=4), OpenWeight(1)), OpenWeight(None)).opened is None


def test_a_recorded_moment_is_gone_to_and_held():
    shown = after(watching(), ShowMoment(1, 3))
    assert (shown.episode, shown.position, shown.is_playing) == (1, 3.0, False)
    assert after(watching(), ShowMoment(1, 99)).position == 4  # The end of that episode.


def test_the_imagined_path_can_be_hidden():
    assert not after(watching(), ShowAhead(None)).shows_ahead
    assert after(after(watching(), ShowAhead(None)), ShowAhead(None)).shows_ahead
    assert not after(watching(), ShowAhead(False)).shows_ahead


def test_uses_are_the_steps_at_which_an_option_had_a_say():
    silent = decision(shares=np.array([1.0, 0.0]))
    episodes = (episode(4), episode(2, decisions=(silent, decision(action=0))))
    assert find_uses(episodes, 4, 1) == [Use(0, 1, 1, 0.75), Use(0, 3, 1, 0.75), Use(1, 0, 1, 1.0)]
    assert [(u.episode, u.step) for u in find_uses(episodes, 1)] == [
        *((0, step) for step in range(4)),
        (1, 1),
    ]
    assert find_uses(episodes, 3) == []


def test_a_thinker_answers_as_the_agent_itself_would(agent, saved, thinker):
    seen = saved.episodes[0].observations[5]
    way = answer_of(lambda: thinker.ahead(saved.learned, seen))
    same = look_ahead(agent.explain.mind, seen, 60)
    assert [step.option for step in way.steps] == [step.option for step in same.steps]
    assert way.reward == same.reward
    assert thinker.ahead(saved.learned, seen) is way  # It is not thought about twice.
    option = int(saved.episodes[0].decisions[5].path[-1])
    origin = answer_of(lambda: thinker.origin(saved.learned, option, 0))
    assert isinstance(origin, Origin)
    assert origin.weight == saved.forest_view().weights[option, 0]


def test_what_cannot_be_answered_is_told_in_words(thinker):
    paper = AO2("CartPole-v1", "paper", seed=0).learn(60).to_saved()
    answer = answer_of(lambda: thinker.ahead(paper.learned, np.zeros(4)))
    assert isinstance(answer, NoAnswer)
    assert "anticipating" in answer.words


def test_of_an_episode_that_plays_faster_than_thought_some_moments_are_left_out(
    saved, thinker, monkeypatch
):
    is_open, thought = threading.Event(), []

    def think(mind, observation, limit):
        is_open.wait(30)
        thought.append(observation)
        return observation

    monkeypatch.setattr("ao2viz.ui.thinker.look_ahead", think)
    observations = saved.episodes[0].observations
    for seen in observations:
        assert thinker.ahead(saved.learned, seen) is None
    is_open.set()
    last = observations[-1]
    assert answer_of(lambda: thinker.ahead(saved.learned, last)).tolist() == last.tolist()
    assert len(thought) <= 4 < len(observations)


def test_the_reasons_quote_the_weight_and_name_its_ends(saved, thinker):
    option = int(saved.episodes[0].decisions[5].path[-1])
    origin = answer_of(lambda: thinker.origin(saved.learned, option, 1))
    page = html_reasons.reasons(origin, saved.spec)
    assert "push right" in page
    assert "on the way" in page
    assert page.count("<tr>") == 1 + 2 * len(origin.story.steps)
    assert str(origin.ends[0].option) in html_reasons.end_words(origin.ends[0])
    features = tuple(Feature(EVIL, EVIL) for _ in saved.spec.features)
    hostile = replace(saved.spec, features=features, action_names=(EVIL, EVIL))
    assert "<img" not in html_reasons.reasons(origin, hostile)


def test_where_it_leads_is_told_with_what_it_earns(agent, saved):
    way = look_ahead(agent.explain.mind, saved.episodes[0].observations[0], 12)
    page = html_reasons.ahead(way, saved.spec)
    assert "12 steps ahead, 12.0 earned" in page
    assert f"of the options {way.stretches[0][0].option}" in page
    for end, words in ((AheadEnd.ENDED, "have ended"), (AheadEnd.UNKNOWN, "does not know")):
        assert words in html_reasons.ahead_words(replace(way, end=end))
    evil = replace(saved.spec, action_names=(EVIL, EVIL))
    assert "<img" not in html_reasons.ahead(way, evil)


def test_the_imagined_path_is_drawn_from_the_option_that_decided(agent, saved):
    view, made = saved.forest_view(), saved.episodes[0].decisions[3]
    way = look_ahead(agent.explain.mind, made.observation, 30)
    picture = draw(view, lay_out(view), saved.spec, Look())
    drawn = overlay(Moment(made, ahead=way), picture, view, saved.spec)
    np.testing.assert_array_equal(drawn.ahead_end, picture.positions[way.stretches[-1][0].option])
    np.testing.assert_allclose(drawn.ahead[0][0, 0], picture.positions[made.path[-1]], atol=1e-5)
    (told,) = (label for label in drawn.labels if label.text == "expects 30.0 in 30 steps")
    # Wherever it ends, a small screen has room for that.
    narrow = Lens(np.array([0.0, 0.0, 100.0]), np.diag([1.0, -1.0, -1.0]), 0.6, (376.0, 768.0))
    for x in np.linspace(-15, 15, 9):
        assert choose_sides((replace(told, position=(x, 0.0, 0.0)),), drawn, narrow) != [None]
    dashes = np.concatenate(drawn.ahead)
    lengths = np.linalg.norm(dashes[:, 1] - dashes[:, 0], axis=1)
    assert (lengths > 0).all()
    assert len(np.unique(dashes.round(4), axis=0)) == len(dashes)  # Nothing twice.
    nothing = overlay(Moment(made), picture, view, saved.spec).ahead
    assert [len(level) for level in nothing] == [0, 0, 0]


def test_a_long_imagined_way_is_thinner_the_later(agent, saved):
    view, made = saved.forest_view(), saved.episodes[0].decisions[3]
    look = Look(arrangement=Arrangement.STATE_SPACE, axes=(2, 3))
    picture = draw(view, fit_axes(view.values, (2, 3)), saved.spec, look)
    lengths = []
    for steps in (4, 8, 9, 24, 25, 60):  # In the state space a step is a move.
        way = look_ahead(agent.explain.mind, made.observation, steps)
        near, later, last = overlay(Moment(made, ahead=way), picture, view, saved.spec).ahead
        assert (len(later) > 0, len(last) > 0) == (steps > 8, steps > 24)
        lengths.append(len(near))
    assert 0 < lengths[0] < lengths[1] == lengths[-1]


def test_in_the_state_space_the_imagined_states_are_drawn(agent, saved):
    view, made = saved.forest_view(), saved.episodes[0].decisions[3]
    way = look_ahead(agent.explain.mind, made.observation, 30)
    axes = fit_axes(view.values, (2, 3))
    look = Look(arrangement=Arrangement.STATE_SPACE, axes=(2, 3))
    picture = draw(view, axes, saved.spec, look)
    drawn = overlay(Moment(made, ahead=way), picture, view, saved.spec)
    np.testing.assert_allclose(drawn.ahead_end, axes.place(way.last), atol=1e-4)
