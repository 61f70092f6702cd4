"""Addresses that lead to a moment, read as if everyone wished us ill."""

from dataclasses import replace
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ao2viz.ui import html_replay
from ao2viz.ui.places import command_to, link_to, open_place, read_place
from ao2viz.ui.reduce import reduce
from ao2viz.ui.replay_commands import ShowLink
from ao2viz.ui.session import Session, Wanted
from ao2viz.ui.view import project
from ao2viz.ui.world import ShelfItem
from tests.ui.test_reduce import FILE, watching, world

ODD = ShelfItem(Path("/a b/<i>&?.ao2"), "<i>&?=%#+ ü")
SHELF = (ShelfItem(FILE, "one"), ODD)


@given(st.sampled_from(SHELF), st.integers(0, 9), st.integers(0, 10))
@settings(deadline=None)
def test_a_link_leads_back_to_where_it_was_made(item, number, step):
    here = replace(world(), shelf=SHELF, address="http://localhost:8080/?token=abc")
    here = replace(here, opened={item.path: world().opened[FILE]})
    link = link_to(Session(source=item.path, episode=number, position=float(step)), here)
    assert link.startswith("http://localhost:8080/?token=abc&")
    place = read_place(urlsplit(link).query, SHELF)
    assert place is not None
    assert (place.item, place.wanted) == (item, Wanted(number, step))


def test_the_command_names_the_file_and_the_moment():
    here = replace(world(), address="http://localhost:1/")
    assert command_to(watching(3.0, episode=1), here) == f"ao2viz {FILE} --episode 1 --step 3"
    there = replace(here, shelf=SHELF, opened={ODD.path: here.opened[FILE]})
    command = command_to(Session(source=ODD.path), there)
    assert command == "ao2viz '/a b/<i>&?.ao2' --episode 0 --step 0"


def test_the_run_has_no_link():
    here = replace(world(), address="http://localhost:1/")
    assert link_to(Session(source=None), here) == ""
    notice = reduce(Session(source=None), ShowLink(), here)[1][0]
    assert "Only a recorded episode" in notice.body  # pyright: ignore
    shown = reduce(watching(), ShowLink(), here)[1][0]
    assert "http://localhost:1/?agent=one&episode=0&step=0" in shown.body  # pyright: ignore


@pytest.mark.parametrize("query", ["", "token=abc", "websocket=ws://x", "x=1&y=2", "%%%"])
def test_an_address_that_asks_for_nothing_opens_the_usual(query):
    assert read_place(query, SHELF) is None
    assert open_place(Session(), query, SHELF) == Session()


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("agent=two", "the agent “two”, which is not here"),
        ("agent=../../etc/passwd", "which is not here"),
        ("agent=", "the agent “”"),
        ("agent=one&step=-1", "step “-1”, but a whole number from 0 on is expected"),
        ("agent=one&step=1e3", "whole number"),
        ("agent=one&step=nan", "whole number"),
        ("episode=\uff19", "whole number"),
        ("agent=one&episode=99999999999999999999", "whole number"),
        ("agent=" + "a" * 700, "longer than"),
        ("&".join(f"a{i}=1" for i in range(60)), "more than twenty"),
        ("agent=%00%1b[31m", "which is not here"),
    ],
)
def test_what_cannot_be_is_said_and_nothing_else_happens(query, words):
    with pytest.raises(ValueError, match="The address"):
        read_place(query, SHELF)
    opened = open_place(Session(source=FILE), query, SHELF)
    assert words in opened.remark
    assert opened.remark.isprintable()
    assert replace(opened, remark="") == Session(source=FILE)


@given(st.text(max_size=200) | st.text(max_size=60).map("agent=one&step={}".format))
@settings(deadline=None)
def test_whatever_an_address_says_it_opens_something(query):
    opened = open_place(Session(), query, SHELF)
    assert opened.source in {None, *(item.path for item in SHELF)}
    assert open_place(Session(), query, ()).source is None


def test_the_link_to_a_moment_says_from_what_it_counts():
    view = project(
        watching(position=2.0), replace(world(), shelf=SHELF, address="http://127.0.0.1:1/")
    )
    page = html_replay.links(view)
    assert "episode=0&amp;step=2" in page  # The list of episodes begins with 1.
    assert "count episodes from 0" in page
