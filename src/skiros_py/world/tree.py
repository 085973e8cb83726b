"""The scene as people think of it: what stands on what, lies in what, and is part of what."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.world.element import Element
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT, STRUCTURE

__all__ = ["TreeNode", "tree"]


@dataclass(frozen=True, slots=True)
class TreeNode:
    """One element with what is placed in it and what it is built of.

    Attributes:
        element: The element.
        relation: The relation that ties it to its parent (a placement or a structure), or None at a root.
        children: What hangs on it, sorted by id.
    """

    element: Element
    relation: str | None
    children: tuple[TreeNode, ...]


def tree(view: WorldView) -> tuple[TreeNode, ...]:
    """Returns the scene from its roots (the floor, the unknown location, what is not spatial) down, sorted by id."""
    children: dict[str | None, list[tuple[str, str | None]]] = {}
    for element in view.instances(ELEMENT):
        parent, relation = _tie(view, element)
        children.setdefault(parent, []).append((element, relation))

    def nodes(parent: str | None) -> tuple[TreeNode, ...]:
        return tuple(TreeNode(view.element(e), relation, nodes(e)) for e, relation in children.get(parent, ()))

    return nodes(None)


def _tie(view: WorldView, element: str) -> tuple[str | None, str | None]:
    placement = view.placement(element)
    if placement is not None:
        return placement.place, placement.relation
    owners = view.subjects(STRUCTURE, element)
    if not owners:
        return None, None
    relations = [r for r in view.ontology.sub_relations(STRUCTURE) if view.related(owners[0], r, element)]
    return owners[0], relations[-1]
