"""Branches: the tree of elements attached to an element by some relations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from skiros_py.errors import UsageError
from skiros_py.world.element import Element
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT, PLACEMENT, STRUCTURE

BACKWARDS = "^"
"""Before a relation's name: read from its object to its subject, as in a property path of SPARQL."""

_SCENE = (STRUCTURE, PLACEMENT)
"""The usual view of a scene: parts and placements."""


@dataclass(frozen=True, slots=True)
class Branch:
    """One element with its children.

    Attributes:
        element: The element.
        relation: The narrowest relation that attaches it to its parent; None for the root.
        children: The branches attached to it, sorted by id.
    """

    element: Element
    relation: str | None
    children: tuple[Branch, ...]

    def walk(self) -> Iterator[tuple[int, Branch]]:
        """Yields this branch and all below it, each parent before its children, with its depth (0: this)."""
        waiting = [(0, self)]
        while waiting:
            depth, node = waiting.pop()
            yield depth, node
            waiting += [(depth + 1, child) for child in reversed(node.children)]


def children(view: WorldView, element: str, *relations: str) -> tuple[str, ...]:
    """Returns ids of the direct children of an element, sorted.

    Args:
        view: The world.
        element: Id of the element.
        *relations: By which relations: the children of a subject are the objects, those of a place what is placed
            there. Narrower relations count. ``^`` before the name reads it the other way. Structure and placement
            where none is given.

    Raises:
        UnknownName: There is no such element or relation.
    """
    return tuple(sorted(_hanging(view, element, relations or _SCENE)))


def parent(view: WorldView, element: str, *relations: str) -> str | None:
    """Returns the id of what an element hangs on, or None; the other way round from :func:`children`.

    Raises:
        UnknownName: There is no such element or relation.
        UsageError: It hangs on several.
    """
    view.element(element)
    found = sorted({name for relation in relations or _SCENE for name in _above(view, element, relation)})
    if len(found) > 1:
        raise UsageError(f"{element} hangs on {' and '.join(found)}: name the one relation that is meant")
    return found[0] if found else None


def branch(view: WorldView, element: str, *relations: str) -> Branch:
    """Returns an element with all that hangs on it, however deep; relations as for :func:`children`.

    What hangs on several, or above itself, appears once: where it is met first, nearest to the beginning.

    Raises:
        UnknownName: There is no such element or relation.
    """
    return _grown(view, element, relations or _SCENE, {element})


def tree(view: WorldView) -> tuple[Branch, ...]:
    """Returns the scene from its roots (the floor, the unknown location, what is not spatial) down, sorted by id."""
    roots = [name for name in view.instances(ELEMENT) if view.placement(name) is None and not _owners(view, name)]
    return tuple(_grown(view, root, _SCENE, {root}) for root in roots)


def _grown(view: WorldView, start: str, relations: tuple[str, ...], seen: set[str]) -> Branch:
    below: dict[str, dict[str, str]] = {}
    met = [start]
    for name in met:  # grows
        new = {child: tie for child, tie in _hanging(view, name, relations).items() if child not in seen}
        below[name] = new
        seen |= new.keys()
        met += sorted(new)
    ties = {start: None, **{child: tie for hanging in below.values() for child, tie in hanging.items()}}
    grown: dict[str, Branch] = {}
    for name in reversed(met):  # what hangs on an element was met after it
        grown[name] = Branch(view.element(name), ties[name], tuple(grown.pop(child) for child in sorted(below[name])))
    return grown[start]


def _hanging(view: WorldView, element: str, relations: tuple[str, ...]) -> dict[str, str]:
    """What hangs directly on an element, and by which narrowest relation; the relation given first counts."""
    view.element(element)
    found: dict[str, str] = {}
    for relation in relations:
        for name in _below(view, element, relation):
            found.setdefault(name, _tie(view, element, relation, name))
    return found


def _below(view: WorldView, element: str, relation: str) -> tuple[str, ...]:
    name, backwards = _read(relation)
    return _places(view, element, name) if backwards else _contents(view, element, name)


def _above(view: WorldView, element: str, relation: str) -> tuple[str, ...]:
    name, backwards = _read(relation)
    return _contents(view, element, name) if backwards else _places(view, element, name)


def _read(relation: str) -> tuple[str, bool]:
    return relation.removeprefix(BACKWARDS), relation.startswith(BACKWARDS)


def _contents(view: WorldView, element: str, relation: str) -> tuple[str, ...]:
    """The objects of an element; of a placement, whichever end is the place, what is placed there."""
    if not view.ontology.is_placement(relation):
        return view.objects(element, relation)
    within = view.ontology.sub_relations(relation)
    ends = {*view.subjects(relation, element), *view.objects(element, relation)}
    guests = ((name, view.placement(name)) for name in ends)
    return tuple(name for name, at in guests if at is not None and at.place == element and at.relation in within)


def _places(view: WorldView, element: str, relation: str) -> tuple[str, ...]:
    """The subjects of an element; of a placement, where the element is."""
    if not view.ontology.is_placement(relation):
        return view.subjects(relation, element)
    at = view.placement(element)
    return (at.place,) if at is not None and at.relation in view.ontology.sub_relations(relation) else ()


def _owners(view: WorldView, element: str) -> tuple[str, ...]:
    return view.subjects(STRUCTURE, element)


def _tie(view: WorldView, element: str, relation: str, child: str) -> str:
    name, backwards = _read(relation)
    upper, lower = (child, element) if backwards else (element, child)
    if view.ontology.is_placement(name):
        at = view.placement(lower)
        assert at is not None, "what hangs on an element by a placement is placed"
        return relation.removesuffix(name) + at.relation
    held = [below for below in view.ontology.sub_relations(name) if view.related(upper, below, lower)]
    narrowest = [one for one in held if len(set(view.ontology.sub_relations(one)) & set(held)) == 1]
    return relation.removesuffix(name) + narrowest[0]
