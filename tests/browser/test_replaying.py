"""Going through an episode: moments, conditions, taking over and coming back, links."""

from urllib.parse import urlsplit

from tests.browser.conftest import Open, Window


def stop_when(window: Window, text: str) -> None:
    field = window.field("Stop when")
    field.fill(text)
    field.press("Enter")


def test_a_moment_is_one_click_away(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Moments").click()
    moments = window.view.replay.moments
    moment = next(m for m in moments if m.step > moments[0].step)
    window.press(f"{moment.step:,} · {moment.words}")
    window.wait(lambda: window.view.transport.position == moment.step, "the moment")
    window.page.keyboard.press("2")
    window.wait(lambda: window.view.transport.position < moment.step, "the one before")
    window.press("Moment →")
    window.wait(lambda: window.view.transport.position == moment.step, "the one after")


def test_playing_holds_where_a_condition_is_met(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Moments").click()
    window.press("First step")
    stop_when(window, "margin < banana")
    window.wait_for_text("At character 10: expected a number, but there is “banana”.")
    stop_when(window, "step = 5 or step = 9")
    window.wait_for_text("2 steps of this episode")
    window.page.locator("body").click(position={"x": 700, "y": 20})  # Out of the field.
    window.press("Play")
    window.wait_for_text("Held at step 5: step = 5 or step = 9.")
    assert not window.view.transport.is_playing
    assert window.view.transport.position == 5
    window.press("Stop →")
    window.wait(lambda: window.view.transport.position == 9, "the next stop")
    window.page.keyboard.press("7")
    window.wait(lambda: window.view.transport.position == 5, "the stop before")


def test_taking_over_makes_a_branch_that_leads_back(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.press("First step")
    for _ in range(3):
        window.press("Step forward")
    window.wait(lambda: window.view.transport.position == 3, "step 3")
    main = window.view.episode
    window.page.get_by_role("tab", name="Branch").click()
    other = 1 - int(main.actions[3])
    name = window.view.spec.action_names[other]
    window.press(name.capitalize())
    window.wait_for_text(f"Branch from step 3: you chose {name}.")
    window.wait_for_text("The branch earns")
    branch = window.view.episode
    assert branch is not main
    assert branch.actions[3] == other
    window.press("Step forward")
    window.wait(lambda: window.view.transport.position == 4, "a step of the branch")
    window.press(window.view.spec.action_names[0].capitalize())
    window.wait_for_text("; step 4: you chose")
    window.press("Back to the main line")
    window.wait(lambda: window.view.episode is main, "the main line")
    assert window.view.transport.position == 3
    window.wait(lambda: "Branch from" not in window.text(), "the page to say so")


def test_a_continuous_action_is_a_number(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.choose("Watch", "Pendulum-v1")
    window.wait(lambda: window.view.source.stem == "Pendulum-v1", "the other agent")
    window.wait(lambda: window.view.transport.last > 0, "its episode")
    window.hold()
    window.press("First step")
    window.page.get_by_role("tab", name="Branch").click()
    window.field("Steps (0: all)").fill("4")
    window.field("Number").fill("1.7")
    window.field("Number").press("Enter")
    window.press("Take over with this number")
    window.wait_for_text("Branch from step 0: you chose torque +2.")
    assert len(window.view.episode) == 5


def test_a_link_opens_agent_episode_and_step(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.choose("Watch", "Pendulum-v1")
    window.wait(lambda: window.view.source.stem == "Pendulum-v1", "the other agent")
    window.wait(lambda: len(window.view.episodes) == 2, "its episodes")
    window.hold()
    window.choose("Episode", "2:")
    window.wait(lambda: window.view.episode_index == 1, "its second episode")
    window.hold()
    window.press("First step")
    window.press("Step forward")
    window.wait(lambda: window.view.replay.link.endswith("step=1"), "the link")
    window.page.get_by_role("tab", name="Moments").click()
    window.wait_for_text(window.view.replay.link)
    window.wait_for_text("ao2viz ")
    query = urlsplit(window.view.replay.link).query
    other = open_window(dashboard, query=query)
    other.wait(lambda: other.view.transport.last > 0, "the linked agent")
    other.wait(lambda: other.view.source == window.view.source, "the linked agent")
    view = other.view
    assert view.episode_index == 1
    assert (view.transport.position, view.transport.is_playing) == (1, False)
    # A page without a query opens the usual again, although the browser has the cookie.
    plain = open_window(dashboard)
    plain.wait(lambda: plain.view.transport.last > 0, "the usual agent")
    assert plain.view.source != window.view.source


def test_a_link_to_what_is_not_there_says_so(dashboard, open_window: Open):
    evil = open_window(dashboard, query="agent=%3Cimg%20src=x%3E&step=2")
    evil.wait_for_text("The address asks for the agent “<img src=x>”, which is not here.")
    late = open_window(dashboard, query="agent=CartPole-v1&episode=1&step=99999")
    late.wait_for_text("You asked for step 99,999, but this episode has")


def test_the_past_of_the_forest_can_be_looked_at(dashboard, open_window: Open):
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Past").click()
    window.press("Earlier")
    window.wait_for_text("You are looking at step 1,470 of 1,500 of training.")
    window.wait_for_text("Weights, visits and attention are those after step 1,280")
    window.wait_for_text("had tried nothing, or is newer")
    window.wait_for_text("Seeing what the replay shows, it would have chosen")
    then = window.view.back
    assert then is not None
    assert 0 < len(then.moment.view) <= len(then.past.now)
    window.press("Now")
    window.wait(lambda: window.view.back is None, "now")
    window.wait(lambda: "You are looking at" not in window.text(), "the page to say so")
