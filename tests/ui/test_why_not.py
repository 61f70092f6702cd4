"""Why not another action, and whether anything like it was met: on the page, from the record."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ao2viz.agent import AO2
from ao2viz.explain.contrast import explain_why_not, tell_why_not
from ao2viz.explain.whole import Novelty
from ao2viz.resources import saved_schemas
from ao2viz.store.files import read
from ao2viz.ui import html, html_reasons
from ao2viz.ui.thinker import Thinker
from tests.ui.test_what_if import settled


def pendulum():
    return read(Path(saved_schemas()) / "Pendulum-v1.ao2")


def test_each_other_action_is_told_with_what_stood_against_it():
    saved = pendulum()
    decision, view = saved.episodes[0].decisions[7], saved.forest_view()
    page = html_reasons.why_nots(decision, saved.spec, view)
    assert page.count("<details>") == saved.spec.n_actions - 1
    for other in range(saved.spec.n_actions):
        if other != decision.action:
            told = tell_why_not(explain_why_not(decision, other, view), saved.spec)
            assert html.esc(told) in page


def test_what_nothing_like_was_met_raises_the_alarm():
    saved, thinker = pendulum(), Thinker()
    try:
        known = saved.episodes[0].observations[3]
        for state, is_alarm in ((known, False), (np.array([9.0, 9.0, 99.0]), True)):
            answer = settled(
                lambda state=state: thinker.novelty(saved.learned, state, saved.episodes),
                lambda a: a is not None,
            )
            assert isinstance(answer, Novelty)
            assert answer.is_alarm is is_alarm
            asked = AO2.from_saved(saved).explain.whole.novelty(state)
            assert answer == replace(asked, faithfulness=None)
            assert ("Never seen before" in html_reasons.novelty(answer)) is is_alarm
    finally:
        thinker.close()
