"""The charts beside the forest: an episode's margin and reward, and what can be taken away."""

import csv
import io
import re
from dataclasses import replace

import numpy as np
import pytest

from ao2viz.core.decision import NO_OPTION
from ao2viz.figures.charts import Over
from ao2viz.training.updates import RunUpdate
from ao2viz.ui.commands import ChooseOver, ChooseSmoothing, Download, Table
from ao2viz.ui.downloads import Notify, SaveFile
from ao2viz.ui.html_episode import episode_chart, episode_cursor, episode_words
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session
from ao2viz.ui.view import project
from tests.forests import cartpole, decision, small_view
from tests.ui.test_reduce import after, episode, watching, world

EVIL = "=cmd|' /C calc'!A0"


def points_of(page: str, line: int) -> np.ndarray:
    found = re.findall(r'<polyline points="([^"]*)"', page)[line]
    return np.array([[float(x) for x in pair.split(",")] for pair in found.split()])


def test_the_higher_the_margin_the_higher_the_line():
    decisions = tuple(decision(action_values=np.array([0.0, m])) for m in (1.0, 3.0, 2.0))
    made = episode(3, decisions=decisions, rewards=np.array([0.0, -1.0, 5.0]))
    page = episode_chart(made, cartpole())
    margins, rewards = points_of(page, 0), points_of(page, 1)
    assert np.argsort(-margins[:, 1]).tolist() == [0, 2, 1]  # Downwards in SVG.
    assert np.argsort(-rewards[:, 1]).tolist() == [1, 0, 2]
    assert (margins[:, 0] == rewards[:, 0]).all()
    assert "−1.00 to 5.00" in page
    assert 'role="img"' in page
    assert "Margin and reward of 3 steps" in page


def test_a_long_episode_keeps_its_extremes_in_a_short_line():
    values = np.ones(5_000)
    values[1234] = 9.0
    made = episode(5_000, rewards=values)
    line = points_of(episode_chart(made, cartpole()), 1)
    assert len(line) < 700
    assert line[:, 1].min() < line[:, 1].max()


def test_steps_that_explored_or_made_an_option_are_marked_and_counted():
    plain = episode_chart(episode(4), cartpole())
    assert "explored" not in plain
    decisions = (decision(explored=True), decision(created=4), decision(), decision())
    page = episode_chart(episode(4, decisions=decisions), cartpole())
    assert "explored, above (1)" in page
    assert "new option, below (1)" in page


@pytest.mark.parametrize(("position", "left"), [(0, "0.00%"), (5, "50.00%"), (10, "100.00%")])
def test_the_cursor_stands_at_the_step_that_is_shown(position, left):
    made = episode(10)
    assert f"left:{left}" in episode_cursor(made, position)
    words = episode_words(made, position)
    assert ("return so far" in words) is (position < 10)
    assert f"Step {position}:" in words or "return 10.0" in words


def test_without_an_episode_there_is_nothing_to_draw():
    assert "No episode" in episode_chart(None, None)
    assert episode_cursor(None, 0) == episode_words(episode(0), 0) == ""


def test_training_is_drawn_over_what_was_chosen():
    session = after(after(Session(), ChooseOver(Over.EPISODES)), ChooseSmoothing(5))
    view = project(session, world())
    assert view.charts.over is Over.EPISODES
    assert view.charts.smoothing == 5


def table(kind: Table, session, w) -> list[dict[str, str]]:
    _, (effect,) = reduce(session, Download(kind), w)
    assert isinstance(effect, SaveFile)
    assert re.fullmatch(r"[A-Za-z0-9.-]+\.csv", effect.name)
    return list(csv.DictReader(io.StringIO(effect.content.decode("utf-8-sig"))))


def test_the_steps_of_an_episode_are_taken_away_as_they_were_recorded():
    rows = table(Table.EPISODE, watching(), world())
    assert len(rows) == 10
    assert rows[3]["margin"] == str(decision(action=1).margin)
    assert rows[9]["return so far"] == "10.0"
    assert rows[0]["action name"] == "push left"


def test_an_options_weights_are_taken_away():
    rows = table(Table.OPTION, watching(selected=4), world())
    assert [row["expected return"] for row in rows] == ["90.5", "92.25"]
    assert [row["visits"] for row in rows] == ["3", "12"]


def test_training_episodes_are_taken_away_with_their_seconds():
    update = RunUpdate(
        spec=cartpole(),
        forest=small_view(),
        history=np.array([[20.0, 20.0, 20.0, 5.0], [50.0, 30.0, 30.0, 6.0]]),
        seconds=np.array([np.nan, 1.5]),
    )
    rows = table(Table.TRAINING, Session(source=None), world(update))
    assert [row["return"] for row in rows] == ["20.0", "30.0"]
    assert [row["seconds until then"] for row in rows] == ["", "1.5"]


def test_a_name_that_is_a_formula_is_only_text():
    w = world()
    agent = next(iter(w.opened.values()))
    spec = replace(cartpole(), action_names=(EVIL, "b"))
    hostile = replace(w, opened={path: replace(agent, spec=spec) for path in w.opened})
    assert table(Table.OPTION, watching(selected=4), hostile)[0]["action name"] == f"'{EVIL}"


def test_what_is_not_there_cannot_be_taken_away():
    empty = Session(source=None, selected=NO_OPTION)
    for kind in Table:
        _, (effect,) = reduce(empty, Download(kind), world())
        assert isinstance(effect, Notify)
    assert project(empty, world()).downloads == frozenset()
    assert project(watching(selected=4), world()).downloads == {Table.EPISODE, Table.OPTION}
