"""Graphs as the readers of others see them."""

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import networkx as nx
import numpy as np
import pydot
import pytest

from ao2viz.exports.escaping import one_line
from ao2viz.store.saved import SavedAgent
from tests.exports.agents import HOSTILE
from tests.exports.conftest import Export


def read_dot(path: Path) -> nx.DiGraph:
    (parsed,) = pydot.graph_from_dot_file(str(path), encoding="utf-8") or ()
    graph = nx.DiGraph()
    for node in parsed.get_nodes():
        if (name := node.get_name()) not in {"node", "graph", "edge"}:
            told = {k.strip('"'): str(v).strip('"') for k, v in node.get_attributes().items()}
            graph.add_node(name.strip('"'), **told)
    for edge in parsed.get_edges():
        kind = str(edge.get_attributes()['"kind"']).strip('"')
        graph.add_edge(edge.get_source().strip('"'), edge.get_destination().strip('"'), kind=kind)
    return graph


READERS: dict[str, Callable[[Path], nx.DiGraph]] = {
    "graphml": nx.read_graphml,
    "gexf": nx.read_gexf,
    "dot": read_dot,
    "cytoscape": lambda path: nx.cytoscape_graph(json.loads(path.read_text("utf-8"))),
    "node-link": lambda path: nx.node_link_graph(
        json.loads(path.read_text("utf-8")), edges="links"
    ),
}


# pydot takes a minute for a thousand nodes; Graphviz itself reads a big file further below.
@pytest.mark.parametrize(
    ("format", "name"),
    [(f, n) for f in READERS for n in ("tiny", "pendulum") if (f, n) != ("dot", "pendulum")],
)
def test_others_read_the_same_forest(
    format: str, name: str, request: pytest.FixtureRequest, write: Export
) -> None:
    agent: SavedAgent = request.getfixturevalue(name)
    view = agent.forest_view()
    graph = READERS[format](write(agent, format))
    assert {int(node) for node in graph} == set(np.flatnonzero(view.is_alive).tolist())
    tree = {(int(a), int(b)) for a, b, told in graph.edges(data=True) if told["kind"] == "tree"}
    children = np.flatnonzero(view.is_alive & (view.parents >= 0))
    assert tree == {(int(view.parents[child]), int(child)) for child in children}
    links = {(int(a), int(b)) for a, b, told in graph.edges(data=True) if told["kind"] == "link"}
    assert links == {(a, b) for a, b in view.links.tolist()}
    option = int(children[-1])
    told = graph.nodes[str(option)]
    values = [float(v) for k, v in told.items() if k.startswith("value ")]
    assert values == view.values[option].tolist()
    weights = [float(v) for k, v in told.items() if k.startswith("weight ")]
    assert weights == view.weights[option].tolist()
    assert int(told["visits"]) == view.visits[option].sum()


@pytest.mark.parametrize("format", ["graphml", "gexf", "cytoscape", "node-link"])
def test_names_of_features_survive(format: str, tiny: SavedAgent, write: Export) -> None:
    graph = READERS[format](write(tiny, format))
    names = set(next(iter(graph.nodes(data=True)))[1])
    for i, name in enumerate(HOSTILE):
        assert f"value {i} {one_line(name)}" in names


def test_gephi_gets_places_and_colours(pendulum: SavedAgent, write: Export) -> None:
    graph = nx.read_gexf(write(pendulum, "gexf"))
    places = {
        (told["viz"]["position"]["x"], told["viz"]["position"]["y"])
        for _, told in graph.nodes(data=True)
    }
    assert len(places) == len(graph)
    assert len({tuple(told["viz"]["color"].values()) for _, told in graph.nodes(data=True)}) > 3


@pytest.mark.skipif(shutil.which("neato") is None, reason="Graphviz is not installed.")
@pytest.mark.parametrize("name", ["pendulum", "hostile"])
def test_graphviz_draws_it(name: str, request: pytest.FixtureRequest, write: Export) -> None:
    path = write(request.getfixturevalue(name), "dot")
    done = subprocess.run(
        ["neato", "-n2", "-Tplain", str(path)], check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
