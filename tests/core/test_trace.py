"""The latest steps of an episode, and the real traces that are kept of them."""

import numpy as np
import pytest

from ao2viz.core.assimilation import allocate_trace, keep_stories, lengthen
from ao2viz.core.config import AnticipatingConfig
from ao2viz.core.decision import NO_OPTION
from ao2viz.core.imagination import allocate_imagination, rules_of


def rules(trace_length, story_length):
    config = AnticipatingConfig(trace_length=trace_length, story_length=story_length, gamma=0.5)
    return rules_of(config)


@pytest.mark.parametrize(("trace_length", "story_length"), [(1, 0), (3, 0), (2, 5), (7, 7)])
def test_a_trace_keeps_the_latest_steps_in_order_however_many_there_were(
    trace_length, story_length
):
    trace = allocate_trace(rules(trace_length, story_length))
    kept = max(trace_length, story_length)
    for n in range(50):
        lengthen(trace, n, n % 3, 0.5 * n)
        used = trace.used[0]
        latest = list(range(max(n + 1 - kept, 0), n + 1))
        recent = slice(max(used - kept, 0), used)
        assert trace.options[recent].tolist() == latest
        assert trace.actions[recent].tolist() == [m % 3 for m in latest]
        assert trace.rewards[recent].tolist() == [0.5 * m for m in latest]


def told(steps, end, has_ended, story_length=3):
    """What is kept after these (option, action, reward) that lead to `end`, worth 8."""
    ours = rules(1, story_length)
    trace, imagination = allocate_trace(ours), allocate_imagination(10, 2, 1)
    imagination.value[9] = 8.0
    for step in steps:
        lengthen(trace, *step)
    keep_stories(imagination, trace, end, has_ended, ours)
    return imagination


STEPS = [(0, 1, 100.0), (1, 0, 1.0), (2, 1, 2.0), (3, 0, 4.0)]


def test_a_real_trace_of_full_length_is_kept_for_where_it_began():
    kept = told(STEPS, end=9, has_ended=False)
    # 1 + 2/2 + 4/4, and after three steps an eighth of what the end is worth.
    assert kept.story_reward[1, 0] == 3.0
    assert kept.story_discount[1, 0] == 0.125
    assert kept.story_end[1, 0] == 9
    # No other step has three behind it, and the first has more than that.
    assert np.isnan(np.delete(kept.story_reward.ravel(), 2)).all()


def test_at_the_end_of_an_episode_the_shorter_traces_count_as_well():
    kept = told(STEPS, end=NO_OPTION, has_ended=True)
    assert [kept.story_reward[1, 0], kept.story_reward[2, 1], kept.story_reward[3, 0]] == [3, 4, 4]
    # The task ended: nothing comes after.
    assert kept.story_discount[1:4].max() == 0.0
    assert kept.story_end[1:4].max() == NO_OPTION
    assert np.isnan(kept.story_reward[0]).all()


def test_a_worse_trace_does_not_take_the_place_of_a_better_one():
    ours = rules(1, 1)
    trace, imagination = allocate_trace(ours), allocate_imagination(10, 2, 1)
    for reward, best in [(1.0, 1.0), (0.5, 1.0), (2.0, 2.0)]:
        lengthen(trace, 4, 1, reward)
        keep_stories(imagination, trace, NO_OPTION, True, ours)
        assert imagination.story_reward[4, 1] == best


@pytest.mark.parametrize("story_length", [0, 5])
def test_nothing_is_kept_without_stories_or_before_a_trace_is_long_enough(story_length):
    kept = told(STEPS, end=9, has_ended=False, story_length=story_length)
    assert np.isnan(kept.story_reward).all()
