"""Moments: where the list leads is what it says, and marks mean what the list means."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.core.config import AnticipatingConfig
from ao2viz.explain.conditions import meets
from ao2viz.explain.moments import MOST_OF_A_KIND, MomentKind, course_of, find_moments
from ao2viz.explain.typed_conditions import parse_condition
from ao2viz.recording.episode import Episode
from tests.forests import cartpole, decision

CONFIG = AnticipatingConfig()
STEPS = st.lists(
    st.tuples(
        st.floats(-100, 100, width=32),  # What push right is expected to earn; push left: 50.
        st.booleans(),  # Explored.
        st.booleans(),  # Made an option.
        st.sampled_from([-5.0, 0.0, 1.0]),  # Reward.
        st.floats(0, 1, width=32),  # Distance.
    ),
    min_size=1,
    max_size=30,
)


def episode(steps: list[tuple[float, bool, bool, float, float]]) -> Episode:
    decisions = []
    for value, explored, created, _, distance in steps:
        values = np.array([50.0, value])
        decisions.append(
            replace(
                decision(),
                action=1 if explored else int(values.argmax()),
                action_values=values,
                explored=explored,
                is_tie=value == 50.0,
                created=9 if created else -1,
                path_distances=np.array([[2.0, 1.0, distance], [2.0, 1.0, np.nan]]),
            )
        )
    return Episode(
        env_id="CartPole-v1",
        seed=1,
        observations=np.zeros((len(steps) + 1, 4)),
        actions=np.array([d.action for d in decisions]),
        rewards=np.array([step[3] for step in steps]),
        decisions=tuple(decisions),
        terminated=True,
        truncated=False,
    )


@given(STEPS)
@settings(deadline=None)
def test_every_moment_is_among_the_most_striking_of_its_kind(steps):
    shown = episode(steps)
    found = find_moments(shown, CONFIG)
    assert [m.step for m in found] == sorted(m.step for m in found)
    assert (found[-1].kind, found[-1].step) == (MomentKind.END, len(shown))
    course = course_of(shown, CONFIG)
    for kind in MomentKind:
        listed = [m.step for m in found if m.kind is kind]
        assert len(listed) == len(set(listed)) <= MOST_OF_A_KIND
        others = sorted(set(range(len(shown))) - set(listed))
        chosen = [t for t in others if not (course.ties[t] or shown.decisions[t].explored)]
        for t in listed:
            match kind:
                case MomentKind.LOW_MARGIN:
                    assert not shown.decisions[t].explored
                    assert all(course.margins[t] <= course.margins[o] for o in chosen)
                case MomentKind.EXPLORED | MomentKind.CREATED:
                    assert course.flags[kind][t]
                case MomentKind.REWARD_DROP:
                    assert shown.rewards[t] < shown.rewards[t - 1]
                    assert all(course.drops[t] >= course.drops[o] for o in others)
                case MomentKind.UNSEEN:
                    assert all(course.distances[t] >= course.distances[o] for o in others)


@given(STEPS)
@settings(deadline=None)
def test_marks_conditions_and_the_list_agree(steps):
    shown, spec = episode(steps), cartpole()
    for kind, marked in course_of(shown, CONFIG).flags.items():
        condition = parse_condition(kind.value, spec)
        np.testing.assert_array_equal(meets(condition, shown, spec, CONFIG), marked)
    for moment in find_moments(shown, CONFIG):
        if moment.words.startswith("never seen"):
            assert course_of(shown, CONFIG).flags[MomentKind.UNSEEN][moment.step]


def test_moments_say_what_makes_them_one():
    shown = episode(
        [
            (70.0, False, False, 1.0, 0.1),
            (50.5, False, True, 1.0, 0.5),
            (90.0, True, False, -5.0, 0.2),
        ]
    )
    words = [(m.step, m.words) for m in find_moments(shown, CONFIG, most=1)]
    assert words == [
        (1, "low margin 0.500"),
        (1, "new option, distance 0.500"),
        (1, "never seen, distance 0.500"),
        (2, "explored, margin 40.0"),
        (2, "reward drop 6.00"),
        (3, "end: the task ended"),
    ]
