"""Sentences: they quote the record, name ties and chance first, and claim no more."""

from dataclasses import replace

import numpy as np
import pytest

from ao2viz.core.decision import DecideBy
from ao2viz.explain.sentence import explain, path_steps
from ao2viz.explain.words import amount, count, number, percent, told_apart
from tests.forests import SEEN, cartpole, decision, no_options, plan, small_view

SPEC = cartpole()


def said(**changes: object) -> str:
    return explain(decision(**changes), SPEC, small_view()).reason


def test_a_vote_is_told_with_its_numbers_names_and_units():
    explanation = explain(decision(), SPEC, small_view())
    assert explanation.headline == "push right"
    assert explanation.reason == (
        "Expected to earn 91.5 against 87.2 for push left: 4.25 more. 2 options voted; the most "
        "similar, 4, had the most say: 75 %. It differs most in pole angle: 3.44° there, 4.58° "
        "now."
    )
    assert explanation.marks == ()


def test_the_loudest_voter_is_named_where_it_is_not_the_most_similar():
    text = said(shares=np.array([0.25, 0.75]))
    assert "the most similar, 4, had 25 % of the say, 1 the most: 75 %." in text


def test_a_path_is_told_as_the_choice_of_one_option():
    text = said(
        decide_by=DecideBy.PATH,
        voters=np.array([4]),
        shares=np.array([1.0]),
        voter_weights=np.array([[90.5, 92.25]]),
        action_values=np.array([90.5, 92.25]),
    )
    assert "Expected to earn 92.2 against 90.5 for push left: 1.75 more." in text
    assert "Option 4, the most similar, decided alone." in text
    assert "voted" not in text


def test_an_outlook_is_told_beside_the_options_own_weight():
    text = said(
        decide_by=DecideBy.PATH,
        voters=np.array([4]),
        shares=np.array([1.0]),
        voter_weights=np.array([[90.5, 92.25]]),
        slopes=np.full((2, 4), 0.5),
        action_values=np.array([90.0, 93.5]),
    )
    assert "Expected to earn 93.5 against 90.0 for push left: 3.50 more." in text
    assert (
        "Option 4, the most similar, decided alone: its own weight for push right is 92.2, its "
        "outlook here 93.5." in text
    )


def test_it_is_said_where_the_outlook_goes_against_the_options_own_weights():
    text = said(
        decide_by=DecideBy.PATH,
        voters=np.array([4]),
        shares=np.array([1.0]),
        voter_weights=np.array([[95.0, 92.25]]),
        slopes=np.full((2, 4), 0.5),
        action_values=np.array([90.0, 93.5]),
    )
    assert (
        "its own weight for push right is 92.2, its outlook here 93.5 (by its own weights it "
        "prefers push left)." in text
    )


def test_a_plan_is_told_step_by_step_and_what_was_expected_without_it():
    explanation = explain(decision(plan=plan()), SPEC, small_view())
    assert explanation.headline == "push right"
    assert explanation.reason == (
        "Thinking 3 steps ahead: push right, push right, push left is expected to earn 1.00, 1.00, "
        "1.00 and lead near option 4, worth 91.2, in all 91.5 (discounted) against 87.2 when "
        "beginning with push left. Without thinking, push left was expected to earn more: 90.2 "
        "against 90.0. Option 4 is the most similar now. It differs most in pole angle: 3.44° "
        "there, 4.58° now."
    )
    assert explanation.marks == ("changed its mind",)


def test_nothing_is_said_of_a_mind_that_did_not_change():
    explanation = explain(
        decision(plan=plan(outlook_values=np.array([90.0, 90.0]))), SPEC, small_view()
    )
    assert "Without thinking" not in explanation.reason
    assert explanation.marks == ()


def test_a_plan_tells_the_chance_that_it_ends_the_episode():
    text = said(plan=plan(continues=np.array([1.0, 0.95, 0.9])))
    assert "worth 91.2 (a chance of 10 % that the episode ends on the way), in all" in text
    short = plan(
        actions=np.array([1]),
        states=SEEN[None],
        rewards=np.array([-1.0]),
        continues=np.array([0.0]),
        options=np.array([1]),
        worth=0.0,
    )
    text = said(plan=short)
    assert "Thinking 1 step ahead: push right is expected to earn −1.00 and end the episode" in text


def test_a_plan_without_steps_says_that_nothing_is_known():
    nothing = plan(
        actions=np.empty(0, np.int64),
        states=np.empty((0, 4)),
        rewards=np.empty(0),
        continues=np.empty(0),
        options=np.empty(0, np.int64),
        worth=91.5,
        outlook_values=np.array([90.0, 91.5]),
    )
    assert said(plan=nothing).startswith(
        "Thinking ahead: what follows push right is unknown, and the options expect it to earn "
        "91.5 (discounted) against 87.2 when beginning with push left."
    )


def test_a_tie_between_plans_is_still_a_tie():
    text = said(plan=plan(), action_values=np.array([4.0, 4.0]), is_tie=True)
    assert text.startswith(
        "A tie: push left and push right were expected to earn exactly 4.00. Thinking 3 steps "
        "ahead: push right, push right, push left is expected to earn 1.00, 1.00, 1.00 and lead "
        "near option 4, worth 91.2."
    )


def test_a_tie_is_said_and_not_explained_away():
    explanation = explain(
        decision(action_values=np.array([4.0, 4.0]), is_tie=True), SPEC, small_view()
    )
    assert explanation.reason.startswith(
        "A tie: push left and push right were expected to earn exactly 4.00."
    )
    assert explanation.marks == ("tie",)


def test_exploring_is_said_before_any_number():
    explanation = explain(decision(action=0, explored=True), SPEC, small_view())
    assert explanation.headline == "push left"
    assert explanation.reason.startswith(
        "Exploring: push left was drawn at random. Push right was expected to earn more: 91.5 "
        "against 87.2."
    )
    assert explanation.marks == ("explored",)


def test_exploring_into_the_best_action_is_still_chance():
    text = said(explored=True)
    assert text.startswith(
        "Exploring: push right was drawn at random; it also was expected to earn the most, 91.5."
    )


def test_a_new_option_is_mentioned():
    explanation = explain(decision(created=5), SPEC, small_view())
    assert "an option of its own: 5." in explanation.reason
    assert "new option 5" in explanation.marks


def test_nothing_is_compared_while_there_are_no_options():
    explanation = explain(no_options(created=0, is_tie=True), SPEC, small_view())
    assert explanation.reason == "There were no options to ask yet, so it was drawn at random."
    assert explanation.marks == ("explored", "new option 0")
    assert path_steps(no_options(), SPEC, small_view()) == ()


def test_a_close_call_is_marked_and_its_numbers_can_be_told_apart():
    explanation = explain(decision(action_values=np.array([99.951, 99.9524])), SPEC, small_view())
    assert "close call" in explanation.marks
    assert "Expected to earn 99.952 against 99.951 for push left: 0.00140 more." in (
        explanation.reason
    )


def test_without_the_forest_nothing_is_said_about_options_values():
    assert "differs" not in explain(decision(), SPEC).reason


def test_a_cleansed_option_is_not_described():
    view = small_view()
    gone = replace(view, is_alive=np.array([True, True, True, True, False]))
    assert "differs" not in explain(decision(), SPEC, gone).reason
    assert path_steps(decision(), SPEC, gone)[-1].gaps == ()


def test_the_path_is_the_recorded_one_with_distances_and_gaps():
    made = decision()
    steps = path_steps(made, SPEC, small_view())
    assert [step.option for step in steps] == made.path.tolist() == [0, 1, 4]
    assert [step.distance for step in steps] == made.path_distances[0].tolist()
    last = steps[-1].gaps
    assert (last[0].feature, last[0].seen, last[0].known) == ("pole angle", "4.58°", "3.44°")
    assert sum(gap.share for gap in last) == pytest.approx(1)
    assert [gap.share for gap in last] == sorted((g.share for g in last), reverse=True)


def test_shares_of_a_distance_are_withheld_once_attention_has_changed():
    view = small_view()
    later = replace(view, attention=view.attention * 2)
    gaps = path_steps(decision(), SPEC, later)[0].gaps
    assert all(np.isnan(gap.share) for gap in gaps)
    assert gaps[0].known == "0°"


def test_every_number_of_a_random_decision_is_in_the_record():
    rng = np.random.default_rng(0)
    for _ in range(200):
        values = rng.normal(scale=50, size=2)
        made = decision(action_values=values, action=int(values.argmax()), observation=SEEN)
        reason = explain(made, SPEC, small_view()).reason
        best, other = told_apart(float(values.max()), float(values.min()))
        assert f"Expected to earn {best} against {other}" in reason
        assert f": {number(values.max() - values.min())} more." in reason


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (-3.14159, "−3.14"),
        (1234.5, "1234"),
        (-0.99996, "−1.00"),
        (99.97, "100"),
        (0.00001234, "1.23e−05"),
        (12_345_678, "1.23e+07"),
        (np.nan, "unknown"),
        (-np.inf, "−∞"),
    ],
)
def test_numbers_are_short_and_have_a_real_minus(value, text):
    assert number(value) == text


def test_amounts_have_the_unit_people_know():
    angle, velocity = SPEC.features[2], SPEC.features[1]
    assert amount(-0.0541, angle) == "−3.10°"
    assert amount(0.5, velocity) == "0.500 m/s"


def test_small_words():
    assert count(1, "step") == "1 step"
    assert count(12_000, "step") == "12,000 steps"
    assert percent(0.001) == percent(0.005) == "under 1 %"
    assert percent(0) == "0 %"


def test_numbers_that_differ_look_different():
    assert told_apart(194.584, 194.580, 3.0) == ["194.584", "194.580", "3.00000"]
    assert told_apart(1.0, 1.0) == ["1.00", "1.00"]
    assert told_apart(1.0, 1.0, digits=4) == ["1.000", "1.000"]
    assert told_apart(194.58, 194.5800000001) == ["194.58", "194.5800000001"]
