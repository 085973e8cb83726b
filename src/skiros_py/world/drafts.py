"""Elements that are not yet: written down with what hangs on them, and added all at once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

from skiros_py.errors import UsageError
from skiros_py.world.branches import BACKWARDS, branch
from skiros_py.world.element import Element, Placement, Value, is_abstract
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import POSE, POSE_FRAME

if TYPE_CHECKING:
    from skiros_py.world.transaction import Transaction
    from skiros_py.world.view import WorldView
from skiros_py.world.terms import reached

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
        learned: True for something that the robot was taught.

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
    """Returns a draft of an element and all that hangs on it: a copy, once it is added.

    It has their labels, own values and relations among each other, and their plain relations to others. It does not say
    where the element is. A pose is kept where it is given in the frame of something that is copied too; any other
    is that of the original.

    Args:
        view: The world.
        element: Id of the element.
        *relations: The relations to follow; see :func:`~skiros_py.world.branches.children`.

    Raises:
        UnknownName: There is no such element or relation.
    """
    return _copied(view, element, relations, lambda _: True)


def instantiate(tx: Transaction, abstract: str, placement: Placement | None = None) -> str:
    """Adds to the scene what an abstract element describes, with its pieces and what is placed in them.

    It is copied as by :func:`draft_of`; relations to what else is abstract are left out.

    Args:
        tx: The open transaction.
        abstract: Id of an individual of the ontology or of something learned.
        placement: Where the new element is.

    Returns:
        Its id.

    Raises:
        UnknownName: There is no such element.
        UsageError: It is not abstract.
    """
    if not is_abstract(tx.view.element(abstract).id):
        raise UsageError(f"'{abstract}' is in the scene already; what is instantiated is abstract")
    element_id = _first(add_draft(tx, _copied(tx.view, abstract, (), lambda other: not is_abstract(other))))
    if placement is not None:
        tx.place(element_id, placement.relation, placement.place)
    return element_id


def learn(tx: Transaction, element: str, *relations: str) -> str:
    """Adds to what is learned a copy of an element of the scene and of what hangs on it, as :func:`draft_of` makes it.

    Relations to the rest of the scene are left out: what is learned outlives it. To learn what the scene does not have,
    add a draft with ``learned=True``.

    Returns:
        The id of the copy ("learned:mug_1").

    Raises:
        UnknownName: There is no such element or relation.
        UsageError: It is abstract already.
    """
    if is_abstract(tx.view.element(element).id):
        raise UsageError(f"'{element}' is abstract already; what is learned from is in the scene")
    return _first(add_draft(tx, _copied(tx.view, element, relations, lambda _: False), learned=True))


def _first(ids: Mapping[Draft, str]) -> str:
    return next(iter(ids.values()))


def _copied(view: WorldView, start: str, relations: tuple[str, ...], keeps: Callable[[str], bool]) -> Draft:
    """Copies a branch; ``keeps`` says to which elements outside of it a plain relation is kept."""
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
    """The relations of an element, without those that follow from a narrower one, and without computed ones."""
    ontology = view.ontology
    return [
        (relation, other)
        for relation, declared in ontology.relations.items()
        if declared.family is not Family.COMPUTED
        for other in view.objects(subject, relation)
        if not any(view.related(subject, narrower, other) for narrower in ontology.sub_relations(relation)[1:])
    ]
