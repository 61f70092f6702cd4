"""Plans in a file: as they were made, or refused."""

from dataclasses import fields

import numpy as np
import pytest

from ao2viz import AO2
from ao2viz.store.files import read
from tests.store.hostile import Parts, refuse
from tests.store.test_hostile_arrays import changed


@pytest.fixture(scope="module")
def thinker(tmp_path_factory):
    """An agent whose first recorded episode has no plans and whose second has some."""
    agent = AO2("CartPole-v1", seed=1, warmup_steps=100).learn(600)
    agent.record_episode(1)
    agent.set_think_ahead(2, limit=0)
    agent.record_episode(2)
    path = tmp_path_factory.mktemp("plans") / "a.ao2"
    agent.save(path)
    return agent, path


@pytest.fixture
def parts(thinker) -> Parts:
    return Parts.of(thinker[1])


def test_plans_come_back_to_the_bit(thinker):
    agent, path = thinker
    saved = read(path)
    assert all(decision.plan is None for decision in saved.episodes[0].decisions)
    planned = 0
    for one, other in zip(agent.episodes[1].decisions, saved.episodes[1].decisions, strict=True):
        assert (one.plan is None) == (other.plan is None)
        if one.plan is None or other.plan is None:
            continue
        planned += 1
        for field in fields(one.plan):
            ours, theirs = (np.asarray(getattr(p, field.name)) for p in (one.plan, other.plan))
            assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype), field.name
            assert ours.tobytes() == theirs.tobytes(), field.name
    assert planned > 5


def test_how_far_it_thinks_is_kept(thinker):
    agent, path = thinker
    loaded = AO2.load(path)
    assert loaded.config == agent.config
    assert loaded.evaluate(3).tolist() == agent.evaluate(3).tolist()


def test_an_episode_without_plans_has_no_arrays_for_them(parts):
    assert not any(name.startswith("episodes/0/decisions/plan") for name in parts.members)
    assert any(name.startswith("episodes/1/decisions/plan") for name in parts.members)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("plan_length", lambda a: changed(a, 3), "plans of at most 2 steps"),
        ("plan_length", lambda a: changed(a, -2), "plans of at most 2 steps"),
        ("plan_actions", lambda a: changed(a, 2, (0, 1)), "plan_actions from 0 to 1"),
        ("plan_actions", lambda a: changed(a, -1), "plan_actions from 0 to 1"),
        ("plan_actions", lambda a: changed(a, 1 - a[0, 0]), "begin with the action taken"),
        ("plan_actions", lambda a: a[:, :1], "plan_states' of a recorded"),
        ("plan_actions", lambda a: a[:, 0], "plan_actions' of a recorded"),
        ("plan_states", lambda a: changed(a, np.nan), "finite plan_states"),
        ("plan_rewards", lambda a: changed(a, np.inf), "finite plan_rewards"),
        ("plan_continues", lambda a: changed(a, 1.5), "chances from 0 to 1"),
        ("plan_continues", lambda a: changed(a, np.nan), "finite plan_continues"),
        ("plan_options", lambda a: changed(a, 10**6), "plan_options from 0 to"),
        ("plan_options", lambda a: changed(a, -1), "plan_options from 0 to"),
        ("plan_worth", lambda a: changed(a, np.nan), "finite plan_worth"),
        ("plan_worth", lambda a: a[1:], "plan_worth' of a recorded"),
        ("plan_outlook_values", lambda a: changed(a, np.inf), "finite plan_outlook_values"),
    ],
)  # fmt: skip
def test_plans_that_cannot_be_are_refused(parts, tmp_path, name, change, words):
    whole = f"episodes/1/decisions/{name}.npy"
    parts.set_array(whole, np.ascontiguousarray(change(parts.array(whole))))
    refuse(parts.write(tmp_path / "a.ao2"), words)


@pytest.mark.parametrize("name", ["plan_length", "plan_actions", "plan_worth"])
def test_all_of_a_plan_is_there_or_nothing(parts, tmp_path, name):
    parts.remove(f"episodes/1/decisions/{name}.npy")
    refuse(parts.write(tmp_path / "a.ao2"), "Expected")
