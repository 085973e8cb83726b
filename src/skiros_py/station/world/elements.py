"""Use cases: elements of the world, read and edited one by one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import islice

from skiros_py.api.elements import ElementDetails, ElementPage, ElementPatch, NewElement, Relation, RelationPage
from skiros_py.api.world import ChangePage, Written
from skiros_py.station.requests import ANY_VERSION, LIBRARY, Author, Seen, Service, addressed, require_seen
from skiros_py.station.world.changes import history, written
from skiros_py.station.world.editing import add, change, writing
from skiros_py.station.world.element_views import details, relations, summary
from skiros_py.world.index import Index
from skiros_py.world.names import local_name
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import ELEMENT
from skiros_py.world.world import World


class ElementService(Service):
    """Reads and edits elements."""

    @property
    def _world(self) -> World:
        return self._station.session.world

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
    ) -> ElementPage:
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
        return ElementPage(items=items, next=items[-1].id if len(page) > limit else None)

    def get(self, element: str, computed: Sequence[str] = ()) -> ElementDetails:
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

    def relations(self, element: str, relation: str | None = None, start: int = 0, limit: int = 100) -> RelationPage:
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
        found = relations(view, element) if relation is None else _of(view, element, relation)
        more = str(start + limit) if start + limit < len(found) else None
        return RelationPage(items=found[start : start + limit], next=more)

    def history(self, element: str, beyond: int, limit: int = 100, *, newest_first: bool = True) -> ChangePage:
        """Lists the changes of an element, which may have been removed.

        Raises:
            NotFound: There never was one with this id.
        """
        with addressed():
            return history(self._world, element, beyond, limit, newest_first=newest_first)

    def add(self, new: NewElement, author: Author = LIBRARY) -> ElementDetails:
        """Adds an element with its values, placement and relations, in one transaction.

        Raises:
            WorldError: The world refuses it.
        """
        with writing(self._world, author, new.reason or f"adds a {new.class_ or new.like}") as tx:
            element = add(tx, new)
        return self.get(element)

    def change(
        self, element: str, patch: ElementPatch, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY
    ) -> ElementDetails:
        """Changes label, values and placement of an element in one transaction.

        Raises:
            NotFound: There is no such element.
            StaleVersion: It was changed since the author has seen it.
            WorldError: The world refuses it.
        """
        reason = patch.reason or f"edits {element}"
        self._write(element, seen, author, reason, lambda tx: change(tx, element, patch))
        return self.get(element)

    def remove(
        self, element: str, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY, reason: str = ""
    ) -> Written:
        """Removes an element with its parts; elements placed there move to the place where it was."""
        return self._write(element, seen, author, reason or f"removes {element}", lambda tx: tx.remove(element))

    def relate(
        self,
        element: str,
        relation: str,
        other: str,
        seen: Seen | None = ANY_VERSION,
        author: Author = LIBRARY,
        reason: str = "",
    ) -> Written:
        """States a relation between two elements; a placement moves the element."""
        reason = reason or f"states {element} {relation} {other}"
        return self._write(element, seen, author, reason, lambda tx: tx.relate(element, relation, other))

    def unrelate(
        self,
        element: str,
        relation: str,
        other: str,
        seen: Seen | None = ANY_VERSION,
        author: Author = LIBRARY,
        reason: str = "",
    ) -> Written:
        """Removes a stated relation; not a placement, because every element has one."""
        reason = reason or f"takes back {element} {relation} {other}"
        return self._write(element, seen, author, reason, lambda tx: tx.unrelate(element, relation, other))

    def version(self, element: str) -> int | None:
        """Returns the version of an element; None if it was removed."""
        view = self._world.snapshot()
        return view.stamp(element).change if view.has(element) else None

    def _write(
        self, element: str, seen: Seen | None, author: Author, reason: str, edit: Callable[[Transaction], object]
    ) -> Written:
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


def _of(view: Index, element: str, relation: str) -> list[Relation]:
    family = view.ontology.family(relation).value
    away = {(element, other) for other in view.objects(element, relation)}
    back = {(other, element) for other in view.subjects(relation, element)}
    return [Relation(subject=s, relation=relation, object=o, family=family) for s, o in sorted(away | back)]
