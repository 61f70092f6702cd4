"""Addresses and commands that open the dashboard at a moment; whoever sends one is not believed."""

import shlex
from dataclasses import dataclass, replace
from urllib.parse import parse_qs, urlencode, urlsplit, urlunsplit

from ao2viz.ui.downloads import Notify
from ao2viz.ui.session import Session, Wanted
from ao2viz.ui.watched import agent_of
from ao2viz.ui.world import ShelfItem, World

MAX_QUERY = 600
"""Characters of an address that are looked at."""

AGENT, EPISODE, STEP = "agent", "episode", "step"
_LARGEST = 10**9


@dataclass(frozen=True)
class Place:
    """Where an address leads."""

    item: ShelfItem
    wanted: Wanted


def read_place(query: str, shelf: tuple[ShelfItem, ...]) -> Place | None:
    """The place that the query of an address asks for; None if it asks for none.

    Raises:
        ValueError: If there is no such agent, or a number is none; in one line.
    """
    if len(query) > MAX_QUERY:
        raise ValueError(f"The address is longer than {MAX_QUERY} characters.")
    try:
        fields = parse_qs(query, keep_blank_values=True, max_num_fields=20)
    except ValueError:
        raise ValueError("The address asks for more than twenty things at once.") from None
    if not fields.keys() & {AGENT, EPISODE, STEP}:
        return None
    if not shelf:
        raise ValueError("The address asks for an agent, but there is none to open here.")
    labels = {item.label: item for item in shelf}
    label = fields.get(AGENT, [shelf[0].label])[-1]
    if label not in labels:
        raise ValueError(f"The address asks for the agent {_quote(label)}, which is not here.")
    return Place(labels[label], Wanted(_whole(fields, EPISODE), _whole(fields, STEP)))


def open_place(session: Session, query: str, shelf: tuple[ShelfItem, ...]) -> Session:
    """A fresh session at the place that an address asks for, or with a remark why not."""
    try:
        place = read_place(query, shelf)
    except ValueError as error:
        return replace(session, remark=str(error))
    if place is None:
        return session
    return replace(session, source=place.item.path, wanted=place.wanted, form_source=None)


def _whole(fields: dict[str, list[str]], name: str) -> int | None:
    if name not in fields:
        return None
    text = fields[name][-1]
    if not (text.isascii() and text.isdigit() and len(text) < 12 and int(text) <= _LARGEST):
        raise ValueError(
            f"The address asks for {name} {_quote(text)}, but a whole number from 0 on is expected."
        )
    return int(text)


def _quote(text: str) -> str:
    plain = "".join(c if c.isprintable() else "�" for c in text)
    return f"“{plain[:40]}{'…' if len(plain) > 40 else ''}”"


def link_to(session: Session, world: World) -> str:
    """What opens this moment in a browser; empty where there is nothing recorded to open.

    Of a branch it opens the step of departure: the branch itself is kept nowhere.
    """
    item = next((i for i in world.shelf if i.path == session.source), None)
    agent = agent_of(session, world)
    if item is None or agent is None or not agent.episodes:
        return ""
    asked = urlencode({AGENT: item.label, EPISODE: session.episode, STEP: _step(session)})
    parts = urlsplit(world.address)
    return urlunsplit(parts._replace(query="&".join(filter(None, (parts.query, asked)))))


def command_to(session: Session, world: World) -> str:
    """What opens this moment from a terminal; empty where there is nothing recorded to open."""
    if session.source is None or not link_to(session, world):
        return ""
    file = shlex.quote(str(session.source))
    return f"ao2viz {file} --episode {session.episode} --step {_step(session)}"


def make_link(session: Session, world: World) -> Notify:
    """Both, as a message to copy from."""
    link = link_to(session, world)
    if not link:
        return Notify("No link", "Only a recorded episode of an agent file can be linked to.")
    return Notify("Link to this moment", f"{link}\n\n{command_to(session, world)}", stays=True)


def _step(session: Session) -> int:
    return int(session.position) if session.branch is None else session.branch.departure
