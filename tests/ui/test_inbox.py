"""Where clicks wait for the app loop."""

from threading import Timer

from ao2viz.ui.commands import Fit
from ao2viz.ui.inbox import Inbox


def test_who_waits_for_commands_is_woken_by_one_and_misses_none():
    inbox = Inbox()
    inbox.put(1, Fit())
    inbox.wait(3600.0)  # One has come already.
    assert inbox.drain() == [(1, Fit())]
    late = Timer(0.05, lambda: inbox.put(2, Fit()))
    late.start()
    inbox.wait(3600.0)
    assert inbox.drain() == [(2, Fit())]
    late.join()
    inbox.wait(0.0)
    assert inbox.drain() == []
