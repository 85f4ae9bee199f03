"""The joints of a graph of links that make a tree; all others close loops."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import NamedTuple


class Edge(NamedTuple):
    """A joint: names of its links, and a number by which the tree takes it before others."""

    parent: str
    child: str
    rank: int


class SpanningTree(NamedTuple):
    """A tree of links.

    Attributes:
        tree: by the index of each joint in it, the name of the link that it carries, from the root outwards.
        lost: names of links that no joints connect to the root.
    """

    tree: Mapping[int, str]
    lost: tuple[str, ...]


def spanning_tree(root: str, links: Sequence[str], edges: Sequence[Edge]) -> SpanningTree:
    """A tree with as many joints of the lowest ranks as there can be, in which joints carry their children.

    Where a joint is the only one of its rank that could carry a link, and has it for its parent, it carries its parent.
    """
    groups = {link: {link} for link in links}
    taken: list[int] = []
    carried: set[str] = {root}
    for rank, as_written in itertools.product(sorted({edge.rank for edge in edges}), (True, False)):
        for k, (parent, child, own) in enumerate(edges):
            if own != rank or groups[parent] is groups[child] or (as_written and child in carried):
                continue
            carried.add(child)
            taken.append(k)
            joined = groups[parent] | groups[child]
            groups.update(dict.fromkeys(joined, joined))
    around: dict[str, list[tuple[int, str]]] = {}
    for k in sorted(taken):
        around.setdefault(edges[k].parent, []).append((k, edges[k].child))
        around.setdefault(edges[k].child, []).append((k, edges[k].parent))
    tree: dict[int, str] = {}
    reached = [root]
    for link in reached:  # grows as it goes
        for k, other in around.get(link, ()):
            if k not in tree:
                tree[k] = other
                reached.append(other)
    return SpanningTree(tree, tuple(link for link in links if link not in reached))
