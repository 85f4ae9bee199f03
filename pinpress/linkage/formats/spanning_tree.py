"""The joints of a graph of links that make a tree; all others close loops."""

from __future__ import annotations

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
    """A tree in which every link is carried by the first joint of which it is the child, as far as that is possible.

    Where it is not, a joint is taken that has the link for its parent: it then carries its parent.
    """
    groups = {link: {link} for link in links}
    taken: list[int] = []
    carried: set[str] = {root}
    order = sorted(range(len(edges)), key=lambda k: edges[k].rank)
    for as_written in (True, False):
        for k in order:
            parent, child = edges[k].parent, edges[k].child
            if groups[parent] is groups[child] or (as_written and child in carried):
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
