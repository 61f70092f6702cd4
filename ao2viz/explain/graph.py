"""The forest as a networkx graph, for everything that networkx can do with it."""

import networkx as nx

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import ForestView


def to_networkx(view: ForestView) -> nx.DiGraph:
    """Living options as nodes, named by id, with edges from parent to child.

    Nodes carry `value` (tuple of D), `weights`, `visits` (tuples of A), `depth` and `born`; edges
    carry `kind`, "tree" or "link" (an extra parent beside the tree).
    """
    graph = nx.DiGraph(attention=tuple(view.attention.tolist()))
    for option in view.is_alive.nonzero()[0].tolist():
        graph.add_node(
            option,
            value=tuple(view.values[option].tolist()),
            weights=tuple(view.weights[option].tolist()),
            visits=tuple(view.visits[option].tolist()),
            depth=int(view.depths[option]),
            born=int(view.born[option]),
        )
    for option in list(graph):
        parent = int(view.parents[option])
        if parent != NO_OPTION:
            graph.add_edge(parent, option, kind="tree")
    graph.add_edges_from(view.links.tolist(), kind="link")
    return graph
