"""The forest as a graph in the formats of Gephi, Graphviz, Cytoscape, D3 and networkx."""

import io
import json
from typing import IO, Any

import networkx as nx
import numpy as np

from ao2viz.explain.graph import to_networkx
from ao2viz.exports.content import Content
from ao2viz.exports.escaping import one_line, to_dot
from ao2viz.figures.palette import UNTRIED, action_colors, to_hex
from ao2viz.layout.discs import lay_out

# Between options that stand closest, in the units of programs that draw graphs.
_SPACING = 20.0


def to_flat_graph(content: Content) -> nx.DiGraph:
    """The forest with one number or text an attribute, which every format can hold.

    Nodes are options, named by id as text. Beside what `to_networkx` tells they have `prefers`,
    `color`, and `x` and `y` as the dashboard draws them. Names of features and actions are in the
    attributes' names, after their position: two may be called alike.
    """
    spec, view = content.spec, content.view
    colors = action_colors(spec.n_actions, is_ordered=spec.action_grid is not None)
    features = [f"value {i} {one_line(f.name)}" for i, f in enumerate(spec.features)]
    actions = [f"{i} {one_line(name)}" for i, name in enumerate(spec.action_names)]
    positions = lay_out(view).positions * _SPACING
    best = view.best_actions
    graph = nx.DiGraph()
    rich = to_networkx(view)
    total = max(len(rich), 1)
    for done, (option, told) in enumerate(rich.nodes(data=True)):
        is_tried = any(told["visits"])
        graph.add_node(
            str(option),
            label=str(option),
            depth=told["depth"],
            born=told["born"],
            prefers=one_line(spec.action_names[best[option]]) if is_tried else "",
            color=to_hex(colors[best[option]] if is_tried else UNTRIED),
            x=float(positions[option, 0]),
            y=float(positions[option, 1]),
            visits=sum(told["visits"]),
            **dict(zip(features, told["value"], strict=True)),
            **{f"weight {name}": w for name, w in zip(actions, told["weights"], strict=True)},
            **{f"visits {name}": n for name, n in zip(actions, told["visits"], strict=True)},
        )
        content.progress((done + 1) / total)
    for parent, child, told in rich.edges(data=True):
        graph.add_edge(str(parent), str(child), kind=told["kind"])
    return graph


def write_graphml(content: Content, stream: IO[bytes]) -> None:
    """GraphML: yEd, Gephi, igraph, networkx."""
    nx.write_graphml_xml(to_flat_graph(content), stream)


def write_gexf(content: Content, stream: IO[bytes]) -> None:
    """GEXF: Gephi, with places, colours and sizes as the dashboard draws them."""
    graph = to_flat_graph(content)
    for _, told in graph.nodes(data=True):
        color = told.pop("color")
        r, g, b = (int(color[i : i + 2], 16) for i in (1, 3, 5))
        told["viz"] = {
            "color": {"r": r, "g": g, "b": b, "a": 1.0},
            "position": {"x": told.pop("x"), "y": told.pop("y"), "z": 0.0},
            "size": float(5 + np.log2(1 + told["visits"])),
        }
    nx.write_gexf(graph, stream)


def write_dot(content: Content, stream: IO[bytes]) -> None:
    """DOT: Graphviz, which keeps the places with `neato -n2`."""
    graph = to_flat_graph(content)
    text = io.TextIOWrapper(stream, "utf-8", write_through=True)
    text.write(f"digraph {to_dot(content.spec.title)} {{\n")
    text.write('  graph [charset="UTF-8"];\n')
    text.write("  node [shape=circle, style=filled, width=0.2, fixedsize=true, fontsize=5];\n")
    for option, told in graph.nodes(data=True):
        x, y, color = told.pop("x"), told.pop("y"), told.pop("color")
        shown = {"pos": f"{x:.2f},{y:.2f}", "fillcolor": color, **told}
        text.write(f"  {to_dot(option)} [{_attributes(shown)}];\n")
    for parent, child, told in graph.edges(data=True):
        style = {"kind": told["kind"], "style": "dashed" if told["kind"] == "link" else "solid"}
        text.write(f"  {to_dot(parent)} -> {to_dot(child)} [{_attributes(style)}];\n")
    text.write("}\n")
    text.detach()  # The stream is the caller's to close.


def write_cytoscape(content: Content, stream: IO[bytes]) -> None:
    """Cytoscape.js JSON, with places."""
    graph = to_flat_graph(content)
    document = nx.cytoscape_data(graph)
    for node in document["elements"]["nodes"]:
        # Its y axis points down.
        node["position"] = {"x": node["data"]["x"], "y": -node["data"]["y"]}
    _write_json(document, stream)


def write_node_link(content: Content, stream: IO[bytes]) -> None:
    """Node-link JSON: D3, networkx."""
    _write_json(nx.node_link_data(to_flat_graph(content), edges="links"), stream)


def _attributes(told: dict[str, Any]) -> str:
    return ", ".join(f"{to_dot(name)}={to_dot(value)}" for name, value in told.items())


def _write_json(document: dict[str, Any], stream: IO[bytes]) -> None:
    stream.write(json.dumps(document, ensure_ascii=False, allow_nan=False).encode())
