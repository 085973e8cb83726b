"""Branches: the tree of elements attached to an element; drafts of elements before they are added."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from skiros_py.errors import UsageError
from skiros_py.world.element import Element, Placement, Value, is_abstract
from skiros_py.world.terms import Family, reached
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT, PLACEMENT, POSE, POSE_FRAME, STRUCTURE

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
        *relations: The relations to follow: the children of a subject are the objects, those of a place the elements
            placed there. Sub-relations count. ``^`` before the name inverts it. By default, structure and placement.

    Raises:
        UnknownName: There is no such element or relation.
    """
    return tuple(sorted(_hanging(view, element, relations or _SCENE)))


def parent(view: WorldView, element: str, *relations: str) -> str | None:
    """Returns the id of the parent of an element, or None; the inverse of :func:`children`.

    Raises:
        UnknownName: There is no such element or relation.
        UsageError: It has several parents.
    """
    view.element(element)
    ways = [_read(relation) for relation in relations or _SCENE]
    found = sorted({one for name, back in ways for one in (_contents if back else _places)(view, element, name)})
    if len(found) > 1:
        raise UsageError(f"{element} hangs on {' and '.join(found)}: name the one relation that is meant")
    return found[0] if found else None


def branch(view: WorldView, element: str, *relations: str) -> Branch:
    """Returns an element with all its descendants; relations as for :func:`children`.

    An element with several parents, or in a cycle, appears once: where it is reached first, nearest to the start.

    Raises:
        UnknownName: There is no such element or relation.
    """
    return _grown(view, element, relations or _SCENE, {element})


def tree(view: WorldView) -> tuple[Branch, ...]:
    """Returns the scene from its roots (the floor, the unknown location, non-spatial elements), sorted by id."""
    everything = view.instances(ELEMENT)
    roots = [name for name in everything if view.placement(name) is None and not view.subjects(STRUCTURE, name)]
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
    """The children of an element, each with the narrowest relation; the relation given first counts."""
    view.element(element)
    found: dict[str, str] = {}
    for relation in relations:
        name, backwards = _read(relation)
        for child in (_places if backwards else _contents)(view, element, name):
            found.setdefault(child, _tie(view, element, relation, child))
    return found


def _read(relation: str) -> tuple[str, bool]:
    return relation.removeprefix(BACKWARDS), relation.startswith(BACKWARDS)


def _contents(view: WorldView, element: str, relation: str) -> tuple[str, ...]:
    """The objects of an element; for a placement, the elements placed there, whichever end is the place."""
    if not view.ontology.is_placement(relation):
        return view.objects(element, relation)
    within = view.ontology.sub_relations(relation)
    ends = {*view.subjects(relation, element), *view.objects(element, relation)}
    guests = ((name, view.placement(name)) for name in ends)
    return tuple(name for name, at in guests if at is not None and at.place == element and at.relation in within)


def _places(view: WorldView, element: str, relation: str) -> tuple[str, ...]:
    """The subjects of an element; for a placement, its place."""
    if not view.ontology.is_placement(relation):
        return view.subjects(relation, element)
    at = view.placement(element)
    return (at.place,) if at is not None and at.relation in view.ontology.sub_relations(relation) else ()


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


_To = TypeVar("_To", bound="Draft | str")


@dataclass(eq=False, slots=True)
class Draft:
    """An element to be added, with its relations to other drafts and existing elements.

    >>> kit = Draft("kitting:Kit", relations=[("sk:on", "kit_table")])
    >>> left = kit.relate("sk:hasA", Draft("kitting:Compartment", "left"))
    >>> left.relate("sk:poseFrame", kit)
    >>> left.relate("^sk:in", Draft("kitting:Starter"))

    Attributes:
        class_: CURIE of its class.
        label: Its display name; by default, the class's name.
        properties: Its own values by CURIE of the property.
        relations: (relation, to what), each a draft or an id. ``^`` before the relation: from that to this.
        id: Its id; the next for its class where left out.
    """

    class_: str
    label: str | None = None
    properties: Mapping[str, Value] = field(default_factory=dict)
    relations: list[tuple[str, Draft | str]] = field(default_factory=list, repr=False)
    id: str | None = None

    def relate(self, relation: str, to: _To) -> _To:
        """Adds a relation and returns its object."""
        self.relations.append((relation, to))
        return to

    def all(self) -> list[Draft]:
        """Returns this draft and all that are reached from it, each once, in the order in which they are added."""
        return list(reached([self], lambda draft: (to for _, to in draft.relations if isinstance(to, Draft))))


def add_draft(tx: Transaction, draft: Draft, *, learned: bool = False) -> dict[Draft, str]:
    """Adds a draft and every draft reachable from it, with all their relations; ``tx`` refuses invalid ones.

    Args:
        tx: The open transaction.
        draft: The draft to add.
        learned: True for a learned concept.

    Returns:
        The id of each draft, that of the given one first.
    """
    drafts = draft.all()
    ids = {one: tx.add(one.class_, one.label, one.id, one.properties, learned=learned) for one in drafts}
    for one in drafts:
        for relation, to in one.relations:
            other = ids[to] if isinstance(to, Draft) else to
            name = relation.removeprefix(BACKWARDS)
            subject, object_ = (ids[one], other) if name == relation else (other, ids[one])
            tx.relate(subject, name, object_)
    return ids


def draft_of(view: WorldView, element: str, *relations: str) -> Draft:
    """Returns a draft of an element and its descendants: a copy, once it is added.

    It has their labels, own values and relations among each other, and their plain relations to others, but not the
    placement of the element. A pose is copied only if it is given in the frame of an element that is copied, too.

    Args:
        view: The world.
        element: Id of the element.
        *relations: The relations to follow; see :func:`~skiros_py.world.branches.children`.

    Raises:
        UnknownName: There is no such element or relation.
    """
    return _copied(view, element, relations, lambda _: True)


def instantiate(tx: Transaction, abstract: str, placement: Placement | None = None) -> str:
    """Adds a copy of an abstract element to the scene, with its pieces and the elements placed in them.

    It is copied as by :func:`draft_of`; relations to other abstract elements are left out.

    Args:
        tx: The open transaction.
        abstract: Id of an individual of the ontology or of a learned concept.
        placement: Where the new element is.

    Returns:
        Its id.

    Raises:
        UnknownName: There is no such element.
        UsageError: It is not abstract.
    """
    if not is_abstract(tx.view.element(abstract).id):
        raise UsageError(f"'{abstract}' is in the scene already; what is instantiated is abstract")
    copied = _copied(tx.view, abstract, (), lambda other: not is_abstract(other))
    element_id = add_draft(tx, copied)[copied]
    if placement is not None:
        tx.place(element_id, placement.relation, placement.place)
    return element_id


def learn(tx: Transaction, element: str, *relations: str) -> str:
    """Adds a copy of an element of the scene and its descendants to the learned concepts, as made by :func:`draft_of`.

    Relations to the rest of the scene are left out, since learned concepts outlive it. To learn a concept that is not
    in the scene, add a draft with ``learned=True``.

    Returns:
        The id of the copy ("learned:mug_1").

    Raises:
        UnknownName: There is no such element or relation.
        UsageError: It is abstract already.
    """
    if is_abstract(tx.view.element(element).id):
        raise UsageError(f"'{element}' is abstract already; what is learned from is in the scene")
    copied = _copied(tx.view, element, relations, lambda _: False)
    return add_draft(tx, copied, learned=True)[copied]


def _copied(view: WorldView, start: str, relations: tuple[str, ...], keeps: Callable[[str], bool]) -> Draft:
    """Copies a branch; ``keeps`` selects the elements outside of it to which plain relations are copied."""
    for relation in relations:
        if view.ontology.family(relation.removeprefix(BACKWARDS)) is Family.COMPUTED:
            raise UsageError(f"{relation} is computed: what is copied hangs together by stated relations")
    elements = {node.element.id: node.element for _, node in branch(view, start, *relations).walk()}
    drafts = {name: _alone(view, element, elements.keys()) for name, element in elements.items()}
    order = {name: at for at, name in enumerate(elements)}
    for name, draft in drafts.items():
        for relation, other in _stated(view, name):
            if other in drafts and order[other] < order[name]:  # stated by the first, so that all are reached
                drafts[other].relate(BACKWARDS + relation, draft)
            elif other in drafts:
                draft.relate(relation, drafts[other])
            elif view.ontology.family(relation) is Family.PLAIN and relation != POSE_FRAME and keeps(other):
                draft.relate(relation, other)
    return drafts[start]


def _alone(view: WorldView, element: Element, copied: Collection[str]) -> Draft:
    properties = dict(element.properties)
    if not any(frame in copied for frame in view.objects(element.id, POSE_FRAME)):
        properties.pop(POSE, None)
    return Draft(element.type, element.label, properties)


def _stated(view: WorldView, subject: str) -> list[tuple[str, str]]:
    """The relations of an element, except those implied by a sub-relation, and computed ones."""
    ontology = view.ontology
    return [
        (relation, other)
        for relation, declared in ontology.relations.items()
        if declared.family is not Family.COMPUTED
        for other in view.objects(subject, relation)
        if not any(view.related(subject, narrower, other) for narrower in ontology.sub_relations(relation)[1:])
    ]
