"""What writers read: Markdown as its renderers see it, LaTeX as its parsers do."""

import itertools

import pytest
from markdown_it import MarkdownIt
from pylatexenc.latex2text import LatexNodes2Text
from pylatexenc.latexwalker import LatexWalker

from ao2viz.store.saved import SavedAgent
from tests.exports.agents import HOSTILE, HOSTILE_ACTIONS, HOSTILE_TITLE
from tests.exports.conftest import Export

MARKDOWN = MarkdownIt("gfm-like", {"html": True, "linkify": False})


def cells(page: str) -> list[str]:
    """The text of every table cell, as a reader sees it."""
    tokens = MARKDOWN.parse(page)
    return [
        "".join(child.content for child in after.children or [])
        for token, after in itertools.pairwise(tokens)
        if token.type in {"td_open", "th_open"}
    ]


def test_markdown_tells_every_step(cartpole: SavedAgent, write: Export) -> None:
    shown = cells(write(cartpole, "markdown").read_text("utf-8"))
    last = cartpole.episodes[1].decisions[-1]
    assert " → ".join(map(str, last.path.tolist())) in shown
    assert "Cart pole, 500 steps (CartPole-v1)" in shown
    assert shown[-1].startswith("Expected to earn")


def test_markdown_shows_hostile_names_as_they_are(hostile: SavedAgent, write: Export) -> None:
    page = write(hostile, "markdown").read_text("utf-8")
    shown = cells(page)
    for name in (*HOSTILE, *HOSTILE_ACTIONS):
        assert name in shown
    kinds = {
        child.type for token in MARKDOWN.parse(page) for child in [token, *(token.children or [])]
    }
    assert not kinds & {"html_inline", "html_block", "link_open", "image", "strong_open", "em_open"}
    assert f"# {HOSTILE_TITLE}" not in page


@pytest.mark.parametrize("name", ["cartpole", "hostile"])
def test_latex_is_one_sound_table(name: str, request: pytest.FixtureRequest, write: Export) -> None:
    agent = request.getfixturevalue(name)
    source = write(agent, "latex").read_text("utf-8")
    nodes, _, length = LatexWalker(source, tolerant_parsing=False).get_latex_nodes()
    assert length == len(source)
    assert r"\input" not in source
    rows = source.split(r"\endfoot")[1].split(r"\end{longtable}")[0].strip().splitlines()
    assert len(rows) == len(agent.episodes[1])
    columns = agent.spec.n_features + 5
    assert all(row.replace(r"\&", "").count("&") == columns - 1 for row in rows)
    assert nodes


def test_latex_shows_hostile_names_as_they_are(hostile: SavedAgent, write: Export) -> None:
    source = write(hostile, "latex").read_text("utf-8")
    text = LatexNodes2Text().latex_to_text(source)
    assert "<script>alert(1)</script>" in text
    assert HOSTILE[3].translate({34: "”", 94: "\u02c6"}) in text


def test_latex_shows_units(cartpole: SavedAgent, write: Export) -> None:
    text = LatexNodes2Text().latex_to_text(write(cartpole, "latex", episode=0).read_text("utf-8"))
    assert "episode 0, seed" in text
    assert "°/s" in text


def test_a_negative_return_has_a_real_minus_sign(pendulum: SavedAgent, write: Export) -> None:
    for format in ("markdown", "html"):
        page = write(pendulum, format).read_text("utf-8")
        assert f"return −{-pendulum.episodes[1].total_reward:.6g} in 40 steps" in page
