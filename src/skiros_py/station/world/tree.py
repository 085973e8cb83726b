"""The world as a tree of placements and parts."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from skiros_py.api.elements import TreeNode
from skiros_py.world.index import Index
from skiros_py.world.vocabulary import ELEMENT, MODULE, ROOT, SPATIAL_THING, STRUCTURE

MOST_NODES = 2000
"""Maximum number of nodes of one answer: those nearest to the root; clients request the others."""

_TOP = ""
"""The node above everything."""


@dataclass(slots=True)
class _Draft:
    name: str
    relation: str = ""
    children: list[_Draft] = field(default_factory=list)
    total: int = 0
    next: str | None = None


def tree(view: Index, root: str, depth: int, limit: int, after: str = "") -> TreeNode:
    """Returns an element with its descendants.

    Args:
        view: The state.
        root: Its id; "" for the node above everything.
        depth: Number of levels below it.
        limit: Maximum number of children of each node.
        after: Only children of the root after this id.

    Raises:
        UnknownName: There is no such element.
    """
    if root != _TOP:
        view.element(root)
    top = _Draft(root)
    waiting = deque([(top, depth)])
    budget = MOST_NODES
    while waiting:
        draft, levels = waiting.popleft()
        found = sorted(_children(view, draft.name))
        draft.total = len(found)
        start = bisect_right(found, after, key=_id) if draft is top else 0
        shown = found[start : start + min(limit, budget)] if levels else []
        draft.children = [_Draft(name, relation) for name, relation in shown]
        budget -= len(shown)
        if shown and start + len(shown) < len(found):
            draft.next = shown[-1][0]
        waiting.extend((child, levels - 1) for child in draft.children)
    return _tree_node(view, top)


def _id(child: tuple[str, str]) -> str:
    return child[0]


def _children(view: Index, name: str) -> Iterator[tuple[str, str]]:
    """Yields the children of an element, each with its relation."""
    if name == _TOP:
        yield from ((child, "") for child in _roots(view))
        return
    for relation in view.ontology.sub_relations(STRUCTURE)[1:]:
        yield from ((piece, relation) for piece in view.objects(name, relation))
    for guest in view.contents(name):
        placement = view.placement(guest)
        if placement is not None:
            yield guest, placement.relation


def _roots(view: Index) -> set[str]:
    """Returns elements that are neither placed nor pieces; without modules, which are many and shown elsewhere."""
    known = view.ontology.classes
    elsewhere = {name for class_ in (SPATIAL_THING, MODULE) if class_ in known for name in view.instances(class_)}
    loose = set(view.instances(ELEMENT)) - elsewhere
    return set(view.instances(ROOT)) | {name for name in loose if not view.owners(name)}


def _tree_node(view: Index, draft: _Draft) -> TreeNode:
    element = None if draft.name == _TOP else view.element(draft.name)
    return TreeNode(
        id=draft.name,
        class_="" if element is None else element.type,
        label="world" if element is None else element.label,
        relation=draft.relation,
        version=view.version if element is None else view.stamp(draft.name).change,
        children=[_tree_node(view, child) for child in draft.children],
        children_total=draft.total,
        next=draft.next,
    )
