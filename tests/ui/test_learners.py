"""The paper's learners behind what is watched: chosen, told in words, taken away."""

import csv
import io
from dataclasses import replace

import numpy as np

from ao2viz.training.updates import RunUpdate
from ao2viz.ui.commands import Download, LayBehind, Table
from ao2viz.ui.downloads import SaveFile
from ao2viz.ui.html_learners import beside_learners, why_none
from ao2viz.ui.learners import Learners
from ao2viz.ui.reduce import reduce
from ao2viz.ui.session import Session
from ao2viz.ui.view import project
from tests.figures.curves import behind
from tests.forests import cartpole, small_view
from tests.ui.test_reduce import after, world

CURVES = (behind("PPO", 0), behind("DAC+PPO", 1), behind("SAC", 2, env="Pendulum-v1"))
RUN = RunUpdate(
    spec=cartpole(),
    forest=small_view(),
    history=np.array([[20.0, 40.0, 20.0, 5.0], [1200.0, 80.0, 30.0, 6.0]]),
)
WORLD = world(RUN, curves=CURVES)
LIVE = Session(source=None)


def laid(session: Session) -> list[str]:
    return [one.learner for one in project(session, WORLD).learners.laid]


def test_learners_of_the_task_are_laid_behind_and_taken_away():
    assert [one.learner for one in project(LIVE, WORLD).learners.known] == ["PPO", "DAC+PPO"]
    assert laid(LIVE) == []
    one = after(LIVE, LayBehind("DAC+PPO", is_laid=True), WORLD)
    assert laid(one) == ["DAC+PPO"]
    every = after(one, LayBehind(), WORLD)
    assert laid(every) == ["PPO", "DAC+PPO"]
    assert laid(after(every, LayBehind("PPO", is_laid=False), WORLD)) == ["DAC+PPO"]
    assert laid(after(every, LayBehind(), WORLD)) == []


def test_a_choice_outlives_a_look_at_another_task():
    chosen = after(LIVE, LayBehind("PPO"), WORLD)
    elsewhere = replace(cartpole(), env_id="Pendulum-v1")
    there = replace(WORLD, update=replace(RUN, spec=elsewhere))
    assert project(chosen, there).learners.laid == ()
    assert laid(chosen) == ["PPO"]


def test_the_words_say_what_the_lines_say():
    learners = project(LIVE, WORLD).learners
    words = beside_learners(learners, learners.known)
    assert "You are at 1,200 steps: 60.0 over its latest 2 episodes." in words
    # At 1,000 steps its mean is 60, which is what the run has; in the end it has 150.
    assert '<td class="ao-num">60.0</td><td class="ao-num">1,000</td>' in words
    assert "150 at 10k" in words
    assert "Means of 2 seeds" in words
    better = replace(learners, here=replace(learners.here, value=151.0))
    assert "never" in beside_learners(better, better.known)
    early = replace(learners, here=replace(learners.here, steps=99))
    assert '<td class="ao-num">–</td>' in beside_learners(early, early.known)
    assert "No training episode" in beside_learners(replace(learners, here=None), learners.known)


def test_where_there_are_no_curves_the_words_say_of_what_there_are():
    assert why_none(project(LIVE, WORLD).learners) == ""
    other = why_none(Learners(env="My<Env>-v0", envs=("CartPole-v0", "Pendulum-v1")))
    assert "no learning curves of My&lt;Env&gt;-v0; there are of CartPole-v0, Pendulum-v1" in other
    assert "ao2viz paper makes them" in why_none(Learners(env="CartPole-v1"))
    assert "No task is watched" in why_none(Learners(envs=("CartPole-v0",)))


def test_the_curves_are_taken_away_those_that_are_laid_or_all():
    def rows(session: Session) -> list[dict[str, str]]:
        _, (effect,) = reduce(session, Download(Table.LEARNERS), WORLD)
        assert isinstance(effect, SaveFile)
        assert effect.name == "CartPole-v1-learners.csv"
        return list(csv.DictReader(io.StringIO(effect.content.decode("utf-8-sig"))))

    assert {row["learner"] for row in rows(LIVE)} == {"PPO", "DAC+PPO"}
    one = rows(after(LIVE, LayBehind("PPO"), WORLD))
    assert [row["mean return"] for row in one] == ["10.0", "50.0", "200.0", "20.0", "70.0", "100.0"]
