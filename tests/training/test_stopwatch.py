"""Seconds of training: work counts, pauses do not."""

import numpy as np

from ao2viz.training.stopwatch import Stopwatch


def test_only_work_is_counted():
    watch = Stopwatch()
    watch.start(100.0)
    watch.mark(101.0)
    watch.stop(103.0)
    watch.mark(500.0)  # A single step while the run is held.
    watch.start(900.0)
    watch.mark(902.0)
    np.testing.assert_array_equal(watch.marks, [1.0, 3.0, 5.0])


def test_episodes_from_before_the_run_have_no_time():
    watch = Stopwatch(2)
    watch.start(0.0)
    watch.mark(4.0)
    np.testing.assert_array_equal(watch.marks, [np.nan, np.nan, 4.0])
