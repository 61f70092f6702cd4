"""Compare: where two agents part is listed, a click goes there, and both play from one seed."""

from ao2viz.agent import AO2
from tests.browser.conftest import Open


def test_where_agents_part_is_listed_and_a_click_goes_there(dashboard, open_window: Open, tmp_path):
    AO2("CartPole-v1", seed=1, warmup_steps=100, levels=2).learn(300).save(tmp_path / "young.ao2")
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Compare").click()
    window.wait(lambda: any(i.label == "young" for i in window.view.shelf), "the file")
    window.choose("With", "young")
    window.wait(lambda: window.view.other is not None, "the other agent")
    window.wait_for_text("STEPS WHERE THEY PART", 120)
    window.wait_for_text("Settings that differ".upper())
    button = window.page.get_by_role("button", name="Step ").filter(has_text=", there ").first
    words = button.inner_text()
    step = int(words.split()[1].rstrip(":"))
    button.click()
    window.wait(lambda: window.view.transport.position == step, "the step")
    window.wait_for_text("they part here")
    names = window.view.spec.action_names
    other = window.view.other.agent
    young = AO2.load(tmp_path / "young.ao2")
    there = young.decide(window.view.observation).action
    assert f"there {names[there]}" in words
    assert names[window.view.decision.action] != names[there]
    assert other.n_steps == 300
    # A click on an option that only one of them has selects it, or the one that is near.
    option = window.page.get_by_role("button", name=" visits").first
    option.scroll_into_view_if_needed()
    selected = int(option.inner_text().split(" ")[0])
    option.click()
    window.wait(lambda: window.view.selected == selected, "the option")


def test_two_agents_play_from_the_same_seed_beside_each_other(
    dashboard, open_window: Open, tmp_path
):
    AO2("CartPole-v1", seed=1, warmup_steps=100, levels=2).learn(300).save(tmp_path / "young.ao2")
    window = open_window(dashboard)
    window.hold()
    window.page.get_by_role("tab", name="Compare").click()
    window.wait(lambda: any(i.label == "young" for i in window.view.shelf), "the file")
    window.choose("With", "young")
    window.press("Play both")
    window.wait_for_text("RETURNS FROM THE SAME SEEDS", 120)
    window.wait_for_text("20 of 20 episodes each", 120)
    panel = window.dashboard._browsers[window._client_id]._compare
    parting = panel._duel.parting
    assert parting is not None
    window.press("Where they part")
    window.wait(lambda: window.view.other.step == parting, "where they part")
    window.wait_for_text(f"They part at step {parting}.")
    one, other = panel._duel.one, panel._duel.other
    assert one.observations[parting].tolist() == other.observations[parting].tolist()
    assert one.actions[parting] != other.actions[parting]
