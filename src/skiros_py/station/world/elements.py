"""Use cases: elements of the world, read and edited one by one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from typing import Any

from skiros_py.api import world as api
from skiros_py.errors import UsageError
from skiros_py.messages import Message
from skiros_py.station.requests import ANY_VERSION, LIBRARY, Author, Seen, Service, addressed, require_seen
from skiros_py.station.world.editing import add, change, history, writing, written
from skiros_py.station.world.values import plain
from skiros_py.world.element import is_abstract
from skiros_py.world.index import Index
from skiros_py.world.names import local_name
from skiros_py.world.poses import map_pose
from skiros_py.world.taught import lesson_about
from skiros_py.world.terms import Family
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import ELEMENT, POSE, POSE_FRAME

_MOST_RELATIONS = 200
"""Maximum number of relations returned with an element."""


def summary(view: Index, name: str) -> api.ElementSummary:
    """Describes an element for a list.

    Raises:
        UnknownName: There is none with this id.
    """
    element, placement = view.element(name), view.placement(name)
    return api.ElementSummary.view_of(
        element,
        id=name,
        class_=element.type,
        placement=None if placement is None else api.Placement(relation=placement.relation, place=placement.place),
        abstract=is_abstract(name),
        version=view.stamp(name).change,
    )


def details(view: Index, name: str, computed: Sequence[str] = ()) -> api.ElementDetails:
    """Describes an element.

    Args:
        view: The state.
        name: Its id.
        computed: Computed relations to include; "all" for all.

    Raises:
        UnknownName: There is none with this id, or no such relation.
        UsageError: A relation is stated, not computed.
    """
    stated = relations(view, name)
    return api.ElementDetails.view_of(
        summary(view, name),
        changed_at=view.stamp(name).time,
        properties=dict(_properties(view, name)),
        relations=stated[:_MOST_RELATIONS],
        relations_total=len(stated),
        computed=computed_relations(view, name, computed),
        owner=next(iter(view.owners(name)), None),
        map_pose=map_pose(view, name),
    )


def relations(view: Index, name: str) -> list[api.Relation]:
    """Returns the stated relations of an element, in both directions, sorted."""
    return list(_relations(view, view.statements_about(name)))


def _relations(view: Index, statements: Iterable[tuple[str, str, str]]) -> Iterator[api.Relation]:
    for subject, relation, object_ in statements:
        family = view.ontology.family(relation).value
        yield api.Relation(subject=subject, relation=relation, object=object_, family=family)


def computed_relations(view: Index, name: str, wanted: Sequence[str]) -> list[api.Relation]:
    """Computes relations of an element: at most 200 of each, in either direction.

    Args:
        view: The state.
        name: Its id.
        wanted: The relations to compute; "all" for all.

    Raises:
        UnknownName: There is no such element or relation, or no reasoner computes it.
        UsageError: A relation is stated, not computed.
    """
    named = dict.fromkeys(each for word in wanted for each in _named(view, word))
    found = {one for relation in named for one in _statements(view, name, relation, _MOST_RELATIONS)}
    return list(_relations(view, sorted(found)))


def _statements(view: Index, name: str, relation: str, most: int | None = None) -> set[tuple[str, str, str]]:
    """Returns the statements of a relation about an element, at most so many in each direction."""
    away = {(name, relation, other) for other in view.objects(name, relation)[:most]}
    return away | {(other, relation, name) for other in view.subjects(relation, name)[:most]}


def _named(view: Index, word: str) -> Sequence[str]:
    ontology = view.ontology
    if word == "all":
        return [name for name in ontology.relations if view.reasoners.computes(name)]
    if ontology.family(word) is not Family.COMPUTED:
        raise UsageError(f"{word} is stated, not computed: it is among the relations of the element already")
    return [word]


# ------------------------------------------------------------------ properties


def _properties(view: Index, name: str) -> Iterator[tuple[str, api.Property]]:
    """Yields the properties of the element, of any origin."""
    for property_ in sorted(view.ontology.properties):
        value = view.value(name, property_)
        if value is not None:
            frame = next(iter(view.objects(name, POSE_FRAME)), None) if property_ == POSE else None
            yield property_, _property(view, name, property_, plain(value, frame))


def _property(view: Index, name: str, property_: str, value: Any) -> api.Property:
    element = view.element(name)
    if property_ in element.properties:
        return api.Property(value=value, origin="own")
    lesson = lesson_about(view, element.type, property_)
    if lesson is None:
        return api.Property(value=value, origin="class")
    return api.Property(value=value, origin="taught", taught_by=lesson.id)


class ElementService(Service):
    """Reads and edits elements."""

    def all(
        self,
        class_: str = ELEMENT,
        *,
        label: str | None = None,
        text: str | None = None,
        place: str | None = None,
        abstract: bool = False,
        limit: int = 100,
        after: str = "",
    ) -> api.ElementPage:
        """Lists elements by id; all conditions must be met.

        Args:
            class_: Only elements of this class or its subclasses.
            label: Only elements with exactly this label.
            text: Only elements with this text in id, label or class, ignoring case.
            place: Only elements placed directly here.
            abstract: True for individuals of the ontology and learned ones, instead of the scene.
            limit: Maximum number of results.
            after: Only ids after this one.
        """
        view = self._world.snapshot()
        names = _among(view, class_, place, abstract=abstract, after=after)
        wanted = (name for name in names if _is_wanted(view, name, label, text))
        page = list(islice(wanted, limit + 1))
        items = [summary(view, name) for name in page[:limit]]
        return api.ElementPage(items=items, next=items[-1].id if len(page) > limit else None)

    def get(self, element: str, computed: Sequence[str] = ()) -> api.ElementDetails:
        """Returns an element: its values with their origin, its relations, and its placement and pose.

        Args:
            element: Its id.
            computed: Computed relations to include; "all" for all.

        Raises:
            NotFound: There is no such element.
        """
        view = self._world.snapshot()
        with addressed():
            view.element(element)
        return details(view, element, list(computed))

    def relations(
        self, element: str, relation: str | None = None, start: int = 0, limit: int = 100
    ) -> api.RelationPage:
        """Lists the relations of an element, in both directions.

        Args:
            element: Its id.
            relation: Only this relation and its subrelations; may be a computed one.
            start: Number of relations to skip.
            limit: Maximum number of results.

        Raises:
            NotFound: There is no such element.
        """
        view = self._world.snapshot()
        with addressed():
            view.element(element)
        if relation is None:
            found = relations(view, element)
        else:
            found = list(_relations(view, sorted(_statements(view, element, relation))))
        more = str(start + limit) if start + limit < len(found) else None
        return api.RelationPage(items=found[start : start + limit], next=more)

    def history(self, element: str, beyond: int, limit: int = 100, *, newest_first: bool = True) -> api.ChangePage:
        """Lists the changes of an element, which may have been removed.

        Raises:
            NotFound: There never was one with this id.
        """
        with addressed():
            return history(self._world, element, beyond, limit, newest_first=newest_first)

    def add(self, new: api.NewElement, author: Author = LIBRARY) -> api.ElementDetails:
        """Adds an element with its values, placement and relations, in one transaction.

        Raises:
            WorldError: The world refuses it.
        """
        with writing(self._world, author, new.reason or Message("adds a {kind}", kind=new.class_ or new.like)) as tx:
            element = add(tx, new)
        return self.get(element)

    def change(
        self, element: str, patch: api.ElementPatch, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY
    ) -> api.ElementDetails:
        """Changes label, values and placement of an element in one transaction.

        Raises:
            NotFound: There is no such element.
            StaleVersion: It was changed since the author has seen it.
            WorldError: The world refuses it.
        """
        self.edit(element, patch, seen, author)
        return self.get(element)

    def edit(
        self, element: str, patch: api.ElementPatch, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY
    ) -> api.Written:
        """Does the same as :meth:`change`, and returns what was written."""
        reason = patch.reason or Message("edits {element}", element=element)
        return self._write(element, seen, author, reason, lambda tx: change(tx, element, patch))

    def remove(
        self, element: str, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY, reason: str = ""
    ) -> api.Written:
        """Removes an element with its parts; elements placed there move to the place where it was."""
        reason = reason or Message("removes {element}", element=element)
        return self._write(element, seen, author, reason, lambda tx: tx.remove(element))

    def relate(
        self,
        element: str,
        relation: str,
        other: str,
        seen: Seen | None = ANY_VERSION,
        author: Author = LIBRARY,
        reason: str = "",
        *,
        holds: bool = True,
    ) -> api.Written:
        """States a relation between two elements, or removes it.

        A placement moves the element; it cannot be removed, because every element has one.

        Args:
            element: Id of the first element.
            relation: Name of the relation.
            other: Id of the second element.
            seen: The version of the first element that the author has seen.
            author: Who writes.
            reason: Why.
            holds: False to remove it.
        """
        stated = {"subject": element, "relation": relation, "object": other}
        if not reason and holds:
            reason = Message("states {subject} {relation} {object}", **stated)
        elif not reason:
            reason = Message("takes back {subject} {relation} {object}", **stated)
        write = Transaction.relate if holds else Transaction.unrelate
        return self._write(element, seen, author, reason, lambda tx: write(tx, element, relation, other))

    def version(self, element: str) -> int | None:
        """Returns the version of an element; None if it was removed."""
        view = self._world.snapshot()
        return view.stamp(element).change if view.has(element) else None

    def _write(
        self, element: str, seen: Seen | None, author: Author, reason: str, edit: Callable[[Transaction], object]
    ) -> api.Written:
        world = self._world
        with addressed():
            now = world.stamp(element).change
        require_seen(seen, now)
        version = seen.version if seen is not None else None
        with writing(world, author, reason, {} if version is None else {element: version}) as tx:
            edit(tx)
        return written(world, tx)


def _among(view: Index, class_: str, place: str | None, *, abstract: bool, after: str) -> Iterator[str]:
    """Yields, in order, the ids of elements of a class and a place after a given id."""
    if place is not None:
        view.element(place)
        contents = view.contents(place)
        ids = set(view.abstracts(class_)).intersection(contents) if abstract else view.instances_among(class_, contents)
    else:
        ids = view.abstracts(class_) if abstract else view.instances(class_)
    return (name for name in sorted(ids) if name > after)


def _is_wanted(view: Index, name: str, label: str | None, text: str | None) -> bool:
    element = view.element(name)
    if label is not None and element.label != label:
        return False
    if not text:
        return True
    wanted = text.casefold()
    return any(wanted in said.casefold() for said in (name, element.label, local_name(element.type)))
