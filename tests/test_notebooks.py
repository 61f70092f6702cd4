"""Notebooks: what is shown for agents, decisions and episodes, and the example that runs."""

import os
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from ao2viz import AO2
from ao2viz.store.saved import SavedAgent
from tests.exports.agents import HOSTILE_TITLE, hostile, shipped
from tests.forests import decision, no_options

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.ipynb"))
ALLOWED = {"div", "b", "table", "tr", "th", "td", "svg", "title", "polyline", "small"}


class _Reader(HTMLParser):
    """The text and the tags of a piece of HTML; whether every tag is closed."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.tags: set[str] = set()
        self.attributes: set[str] = set()
        self.open: list[str] = []
        self.feed(source)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes |= {name for name, _ in attrs}
        self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def read(source: str) -> _Reader:
    reader = _Reader(source)
    assert reader.open == []
    assert reader.tags <= ALLOWED
    assert not {name for name in reader.attributes if name.startswith("on")} | (
        reader.attributes & {"src", "href"}
    )
    assert len(source) < 20_000
    return reader


def test_an_agent_shows_what_it_is() -> None:
    agent = AO2.from_saved(shipped("CartPole-v1"))
    shown = read(agent._repr_html_())
    assert "Cart pole, 500 steps (CartPole-v1)" in shown.texts
    assert f"{len(agent.forest):,} options in " in " ".join(shown.texts)
    assert "polyline" in shown.tags
    fresh = read(AO2("CartPole-v1")._repr_html_())
    assert "0 options in 0 schemas" in fresh.texts
    assert "polyline" not in fresh.tags


def test_a_decision_shows_its_numbers() -> None:
    shown = read(decision()._repr_html_())
    text = " ".join(shown.texts)
    assert " → ".join(str(option) for option in decision().path[:1].tolist()) in text
    assert "decided by" in text
    assert "a tie" in " ".join(read(decision(is_tie=True)._repr_html_()).texts)
    assert "explore" in " ".join(read(decision(explored=True)._repr_html_()).texts)
    assert "there were no options yet" in read(no_options()._repr_html_()).texts


def test_an_episode_shows_how_it_went() -> None:
    episode = shipped("Pendulum-v1").episodes[0]
    shown = read(episode._repr_html_())
    assert f"{episode.total_reward:.6g}" in shown.texts
    assert "still under way" in shown.texts
    assert "polyline" in shown.tags
    empty = replace(episode, actions=episode.actions[:0], decisions=(), rewards=episode.rewards[:0])
    assert "polyline" not in read(empty._repr_html_()).tags


def test_names_are_shown_as_they_are() -> None:
    saved: SavedAgent = hostile()
    assert f"{HOSTILE_TITLE} (CartPole-v1)" in read(AO2.from_saved(saved)._repr_html_()).texts
    named = replace(saved.episodes[0], env_id=HOSTILE_TITLE)
    assert f"Episode of {HOSTILE_TITLE}" in read(named._repr_html_()).texts


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name)
def test_every_example_runs(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = os.environ.get("PYTHONPATH")
    monkeypatch.setenv("PYTHONPATH", str(ROOT) + (os.pathsep + before if before else ""))
    notebook = nbformat.read(path, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells)  # Kept without what it shows.
    NotebookClient(notebook, timeout=240, resources={"metadata": {"path": str(ROOT)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    kinds = {kind for output in outputs for kind in output.get("data", {})}
    assert {"text/html", "image/svg+xml", "image/png"} <= kinds
    assert outputs[-1]["data"]["text/plain"] == "True"


def test_there_is_an_example() -> None:
    assert EXAMPLES
