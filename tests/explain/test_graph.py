"""The forest as a networkx graph."""

import networkx as nx
import numpy as np

from ao2viz.core.decision import NO_OPTION
from ao2viz.core.forest import Forest
from ao2viz.explain.graph import to_networkx
from tests.forests import small_view


def test_nodes_and_tree_edges_carry_everything():
    view = small_view()
    graph = to_networkx(view)
    assert set(graph) == {0, 1, 2, 3, 4}
    assert set(graph.edges) == {(0, 1), (0, 2), (1, 4)}
    assert graph.nodes[4]["value"] == (0.1, 0.2, 0.06, 0.0)
    assert graph.nodes[4]["weights"] == (90.5, 92.25)
    assert graph.nodes[4]["visits"] == (3, 12)
    assert graph.nodes[4]["depth"] == 2
    assert nx.is_forest(graph)


def test_extra_links_are_told_from_the_tree_and_cleansed_options_are_left_out():
    forest = Forest(1, 2, np.ones(1))
    for parent in (NO_OPTION, NO_OPTION, 0, 2):
        forest.add(np.zeros(1), parent, step=1)
    forest.link(1, 2, step=2)
    forest.remove(3, step=3)
    graph = to_networkx(forest.view())
    assert set(graph) == {0, 1, 2}
    assert graph.edges[0, 2]["kind"] == "tree"
    assert graph.edges[1, 2]["kind"] == "link"
