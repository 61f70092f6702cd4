"""The three-dimensional replay, opened from disk with the network off."""

from dataclasses import replace
from pathlib import Path

from playwright.sync_api import Browser

from ao2viz import export
from tests.browser.offline import opened, wait_for_path
from tests.exports.agents import first_steps, hostile


def test_it_plays_without_a_server(browser: Browser, tmp_path: Path, capfd) -> None:
    agent = hostile()
    short = replace(agent, episodes=(first_steps(agent.episodes[0], 8),))
    shares: list[float] = []
    path = export(short, tmp_path / "replay.html", "replay", progress=shares.append)
    assert capfd.readouterr().out == ""
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    with opened(browser, path) as page:
        assert page.title() == f"{agent.spec.title}, episode 1: an AO2 agent's decisions"
        wait_for_path(page)
