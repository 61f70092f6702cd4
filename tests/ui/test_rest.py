"""A page that nobody touches is left alone, and wakes at whatever could change it."""

from dataclasses import replace

import pytest

from ao2viz.ui.app import TICK_S
from ao2viz.ui.rest import HEARTBEAT_S, STAYS_AWAKE_S, Rest
from ao2viz.ui.session import Session
from ao2viz.ui.world import World

SESSION, WORLD = Session(position=3.0, is_playing=False), World()


def looks(rest: Rest, seconds: float, began: float = 0.0, **changed) -> int:
    """How often the screen is brought up to date in so many seconds of ticks."""
    known = {"session": SESSION, "world": WORLD, "camera": 1.0, "is_waiting": False} | changed
    ticks = [began + i * TICK_S for i in range(round(seconds / TICK_S))]
    return sum(
        rest.is_over(
            known["session"],
            known["world"],
            known["camera"],
            is_waiting=known["is_waiting"],
            now=now,
        )
        for now in ticks
    )


def at_rest() -> Rest:
    rest = Rest()
    looks(rest, 10.0)
    return rest


def test_a_page_that_nobody_touches_is_looked_at_once_in_a_while():
    assert looks(at_rest(), 20.0, began=10.0) == pytest.approx(20.0 / HEARTBEAT_S, abs=1)


@pytest.mark.parametrize(
    "changed",
    [
        {"session": replace(SESSION, position=4.0)},
        {"session": replace(SESSION, selected=7)},
        {"session": replace(SESSION, fits=1)},
        {"world": World()},
        {"camera": 2.0},
    ],
)
def test_whatever_could_look_different_wakes_it_for_a_while(changed):
    rest = at_rest()
    assert looks(rest, TICK_S, began=10.0, **changed) == 1
    # What a person has just done may have an echo: controls settle, words wait for a standstill.
    assert looks(rest, STAYS_AWAKE_S - 2 * TICK_S, began=10.0 + TICK_S, **changed) > 10
    assert looks(rest, 10.0, began=20.0, **changed) <= 10.0 / HEARTBEAT_S + 1


def test_a_page_that_waits_for_an_answer_stays_awake():
    assert looks(at_rest(), 5.0, began=10.0, is_waiting=True) == round(5.0 / TICK_S)


def test_a_click_that_changes_nothing_wakes_it():
    rest = at_rest()
    rest.wake()
    assert looks(rest, TICK_S, began=10.0) == 1


def test_between_two_steps_of_a_slow_replay_nothing_happens():
    rest = at_rest()
    creeping = replace(SESSION, position=3.4, is_playing=False)
    assert looks(rest, 0.5, began=10.0, session=creeping) <= 1
