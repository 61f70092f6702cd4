"""The exported page in a real browser: opened from disk, with the network off."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from ao2viz import AO2, export
from ao2viz.store.saved import SavedAgent
from tests.exports.agents import HOSTILE, HOSTILE_ACTIONS, HOSTILE_TITLE, hostile, shipped

OpenReport = Callable[..., Page]


@pytest.fixture
def open_report(browser: Browser, tmp_path: Path) -> Iterator[OpenReport]:
    """Opens a report; an error in the console or any request but for the page fails the test."""
    pages: list[Page] = []
    errors: list[str] = []
    requests: list[str] = []

    def open_one(
        agent: SavedAgent, width: int = 1440, scheme: str = "light", expected: str = "\0"
    ) -> Page:
        path = export(agent, tmp_path / "report.html", "html", overwrite=True)
        context = browser.new_context(
            viewport={"width": width, "height": 900},
            color_scheme=scheme,  # pyright: ignore[reportArgumentType]
            offline=True,
        )
        page = context.new_page()
        pages.append(page)
        page.on("console", lambda m: errors.append(m.text) if expected not in m.text else None)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("dialog", lambda dialog: errors.append(dialog.message))
        page.on("request", lambda request: requests.append(request.url))
        page.goto(path.as_uri())
        return page

    yield open_one
    assert errors == []
    assert requests == [page.url for page in pages]
    for page in pages:
        page.context.close()


def test_it_shows_the_agent_and_every_step(open_report: OpenReport) -> None:
    cartpole = shipped("CartPole-v1")
    page = open_report(cartpole)
    expect(page.get_by_role("heading", level=1)).to_contain_text("Cart pole, 500 steps")
    assert page.locator(".forest circle").count() >= len(shipped("CartPole-v1").forest_view())
    decisions = cartpole.episodes[1].decisions
    for position in (0, 1, 2):
        expect(page.locator("#position")).to_have_text(f"step {position} of 39")
        told = page.locator("#path li b").all_inner_texts()
        path = decisions[position].path.tolist()
        assert told == [f"{'option' if i else 'root'} {option}" for i, option in enumerate(path)]
        action = cartpole.spec.action_names[decisions[position].action]
        expect(page.locator("#headline")).to_have_text(action)
        assert page.locator("#forest-path circle").count() == len(path)
        page.keyboard.press("ArrowRight")
    assert page.locator("#all tbody tr").count() == 40


def test_keys_and_buttons_lead_to_every_step(open_report: OpenReport) -> None:
    page = open_report(shipped("Pendulum-v1"))
    where = page.locator("#position")
    for key, position in (
        ("End", 39),
        ("ArrowRight", 39),
        ("ArrowLeft", 38),
        ("PageUp", 28),
        ("Home", 0),
        ("ArrowLeft", 0),
        ("PageDown", 10),
    ):
        page.keyboard.press(key)
        expect(where).to_have_text(f"step {position} of 39")
    page.get_by_role("button", name="Next step").click()
    expect(where).to_have_text("step 11 of 39")
    page.get_by_role("slider", name="Step").fill("5")
    expect(where).to_have_text("step 5 of 39")
    page.get_by_role("slider", name="Step").press("ArrowRight")
    expect(where).to_have_text("step 6 of 39")
    chart = page.locator("#margins svg")
    box = chart.bounding_box()
    assert box is not None
    chart.click(position={"x": box["width"] * 0.9, "y": 50})
    expect(where).to_have_text(re.compile("step 3[0-9] of"))
    page.get_by_role("button", name="First step").click()
    page.keyboard.press("Tab")
    page.get_by_role("button", name="Play").click()
    expect(where).to_have_text(re.compile("step ([2-9]|[1-3][0-9]) of"))
    page.get_by_role("button", name="Pause").click()
    stopped = where.inner_text()
    page.wait_for_timeout(500)
    assert where.inner_text() == stopped


def test_hostile_names_are_only_names(open_report: OpenReport) -> None:
    page = open_report(hostile())
    expect(page.get_by_role("heading", level=1)).to_contain_text(HOSTILE_TITLE)
    assert page.title().startswith(HOSTILE_TITLE)
    for name in (*HOSTILE, *HOSTILE_ACTIONS):
        assert page.get_by_text(name, exact=True).count() > 0
    assert page.locator("script").count() == 2
    assert page.locator("img, a:not(.skip), b b, [onload], [onerror]").count() == 0
    page.keyboard.press("End")
    expect(page.locator("#position")).to_have_text("step 39 of 39")


def test_what_a_name_smuggles_in_is_not_run(open_report: OpenReport) -> None:
    page = open_report(shipped("CartPole-v1"), expected="Content Security Policy")
    policy = page.locator("meta[http-equiv]").get_attribute("content") or ""
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    ran = page.evaluate(
        """() => {
          const made = document.createElement("script");
          made.textContent = "window.ran = 1";
          document.body.append(made);
          return window.ran === 1;
        }"""
    )
    assert ran is False


@pytest.mark.parametrize("width", [1440, 1024, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_sticks_out_and_everything_can_be_read(
    open_report: OpenReport,
    width: int,
    scheme: str,
) -> None:
    page = open_report(shipped("CartPole-v1"), width, scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    contrast = page.evaluate(
        """() => {
          const light = (color) => {
            const [r, g, b] = color.match(/[\\d.]+/g).slice(0, 3).map((v) => {
              const s = v / 255;
              return s <= 0.03928 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
            });
            return 0.2126 * r + 0.7152 * g + 0.0722 * b;
          };
          const behind = (node) => {
            for (let at = node; at; at = at.parentElement) {
              const color = getComputedStyle(at).backgroundColor;
              if (color !== "rgba(0, 0, 0, 0)") return color;
            }
          };
          const texts = "p, h1, h2, h3, h4, td, th, li, button, figcaption, span, summary, output";
          return [...document.querySelectorAll(texts)]
            .filter((node) => node.innerText.trim() && node.offsetParent)
            .map((node) => {
              const [one, other] = [light(getComputedStyle(node).color), light(behind(node))];
              return (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
            })
            .reduce((least, value) => Math.min(least, value), 21);
        }"""
    )
    assert contrast >= 4.5  # WCAG 2.2, 1.4.3.


def test_a_vote_shows_who_voted(open_report: OpenReport) -> None:
    agent = AO2("CartPole-v1", seed=0, decide_by="vote").learn(400)
    episode = agent.record_episode(1)
    page = open_report(agent.to_saved())
    shares = episode.decisions[0].shares
    assert (shares > 0).sum() > 3
    shown = page.locator("#voters tr")
    expect(shown).to_have_count(int((shares > 0).sum()))
    assert f"option {episode.decisions[0].voters[0]}" in shown.first.inner_text()
    page = open_report(shipped("CartPole-v1"))
    expect(page.locator("#vote")).to_be_hidden()


def test_an_agent_without_episodes_has_a_page_too(open_report: OpenReport) -> None:
    page = open_report(replace(shipped("CartPole-v1"), episodes=()))
    expect(page.get_by_text("No episode is recorded")).to_be_visible()
    assert page.locator(".forest circle").count() >= len(shipped("CartPole-v1").forest_view())
