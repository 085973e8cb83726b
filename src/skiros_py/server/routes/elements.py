"""Routes: elements."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Annotated
from urllib.parse import quote

from fastapi import APIRouter, Query, Response

from skiros_py.api.elements import (
    ElementDetails,
    ElementPage,
    ElementPatch,
    NewElement,
    Relation,
    RelationPage,
)
from skiros_py.api.values import Name
from skiros_py.api.world import ChangePage, Written
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, VersionDep, etag, expected_version, require_version, tagged
from skiros_py.server.problems import found
from skiros_py.server.routes.parameters import ChangeLimit, Cursor, ElementPath, Limit, NamePath, WhyQuery
from skiros_py.server.services import ServicesDep
from skiros_py.server.world.changes import history, written
from skiros_py.server.world.cursors import number_cursor
from skiros_py.server.world.editing import add, change, writing
from skiros_py.station.world.telling import details, relations, summary
from skiros_py.world.index import Index
from skiros_py.world.names import local_name
from skiros_py.world.vocabulary import ELEMENT
from skiros_py.world.world import World

__all__ = ["router"]

router = APIRouter(tags=["elements"])

_LATEST = 2**62
_WRITES = NEEDS_VERSION | tagged()


# ------------------------------------------------------------------ looking


@router.get("/elements", summary="List elements", dependencies=[needs(Role.VIEWER)])
def list_elements(
    services: ServicesDep,
    class_: Annotated[
        str, Query(alias="class", min_length=1, max_length=300, description="Of this class or one below.")
    ] = ELEMENT,
    label: Annotated[str | None, Query(max_length=1000, description="Called exactly so.")] = None,
    text: Annotated[
        str | None, Query(max_length=200, description="With this text in id, label or class; case does not count.")
    ] = None,
    place: Annotated[
        str | None, Query(max_length=300, description="Placed directly here, by whatever relation.")
    ] = None,
    abstract: Annotated[
        bool, Query(description="What the ontology describes and what was learned, instead of the scene.")
    ] = False,
    limit: Limit = 100,
    cursor: Cursor = None,
) -> ElementPage:
    """Lists elements in the order of their ids; all conditions must be met."""
    view = services.session.world.snapshot()
    names = _among(view, class_, place, abstract=abstract, after=cursor or "")
    wanted = (name for name in names if _is_wanted(view, name, label, text))
    page = list(islice(wanted, limit + 1))
    items = [summary(view, name) for name in page[:limit]]
    return ElementPage(items=items, next=items[-1].id if len(page) > limit else None)


def _among(view: Index, class_: str, place: str | None, *, abstract: bool, after: str) -> Iterator[str]:
    """Yields in order the ids of a class, in a place, that come after one."""
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


@router.get("/elements/{element}", summary="Read an element", dependencies=[needs(Role.VIEWER)], responses=tagged())
def read_element(
    element: ElementPath,
    services: ServicesDep,
    response: Response,
    computed: Annotated[
        list[Name],
        Query(max_length=50, description='Computed relations to work out, such as sk:near; "all" for all of them.'),
    ] = [],  # noqa: B006  FastAPI copies it
) -> ElementDetails:
    """Tells its values with their origin, its relations in both directions, and where it is.

    The answer's ETag is what `If-Match` takes when the element is changed.
    """
    return _answered(services.session.world.snapshot(), element, response, computed)


def _answered(view: Index, element: str, response: Response, computed: list[str]) -> ElementDetails:
    with found():
        view.element(element)
    told = details(view, element, computed)
    response.headers["ETag"] = etag(told.version)
    return told


@router.get("/elements/{element}/relations", summary="List an element's relations", dependencies=[needs(Role.VIEWER)])
def list_relations(
    element: ElementPath,
    services: ServicesDep,
    relation: Annotated[
        str | None, Query(max_length=300, description="Only of this relation or one below, also a computed one.")
    ] = None,
    limit: Limit = 100,
    cursor: Cursor = None,
) -> RelationPage:
    """Lists what is stated of an element, in both directions, in order."""
    view = services.session.world.snapshot()
    with found():
        view.element(element)
    start = number_cursor(cursor)
    told = relations(view, element) if relation is None else _of(view, element, relation)
    more = str(start + limit) if start + limit < len(told) else None
    return RelationPage(items=told[start : start + limit], next=more)


def _of(view: Index, element: str, relation: str) -> list[Relation]:
    family = view.ontology.family(relation).value
    away = {(element, other) for other in view.objects(element, relation)}
    back = {(other, element) for other in view.subjects(relation, element)}
    return [Relation(subject=s, relation=relation, object=o, family=family) for s, o in sorted(away | back)]


@router.get("/elements/{element}/history", summary="Read an element's history", dependencies=[needs(Role.VIEWER)])
def read_element_history(
    element: ElementPath,
    services: ServicesDep,
    newest_first: Annotated[bool, Query(description="Go back in time.")] = True,
    limit: ChangeLimit = 100,
    cursor: Cursor = None,
) -> ChangePage:
    """Tells which changes touched an element, by whom and why; the element may be gone."""
    start = number_cursor(cursor, _LATEST if newest_first else 0)
    with found():
        return history(services.session.world, element, start, limit, newest_first=newest_first)


# ------------------------------------------------------------------ writing


@router.post(
    "/elements", summary="Add an element", status_code=201, dependencies=[needs(Role.OPERATOR)], responses=tagged(201)
)
def add_element(new: NewElement, services: ServicesDep, caller: CallerDep, response: Response) -> ElementDetails:
    """Adds an element with its values, its place and its relations, all at once.

    While something runs this changes what is believed, nothing else.
    """
    world = services.session.world
    with writing(world, caller, new.reason or f"adds a {new.class_ or new.like}") as tx:
        element = add(tx, new)
    response.headers["Location"] = f"/api/v1/elements/{quote(element, safe='')}"
    return _answered(world.snapshot(), element, response, [])


@router.patch(
    "/elements/{element}", summary="Change an element", dependencies=[needs(Role.OPERATOR)], responses=_WRITES
)
def change_element(
    element: ElementPath,
    patch: ElementPatch,
    services: ServicesDep,
    caller: CallerDep,
    seen: VersionDep,
    response: Response,
) -> ElementDetails:
    """Changes label, values and place of an element in one transaction; `If-Match` says which version was seen."""
    world = services.session.world
    expects = _expected(world, element, seen)
    with writing(world, caller, patch.reason or f"edits {element}", expects) as tx:
        change(tx, element, patch)
    return _answered(world.snapshot(), element, response, [])


@router.delete(
    "/elements/{element}", summary="Remove an element", dependencies=[needs(Role.OPERATOR)], responses=NEEDS_VERSION
)
def remove_element(
    element: ElementPath, services: ServicesDep, caller: CallerDep, seen: VersionDep, reason: WhyQuery = ""
) -> Written:
    """Removes an element with its pieces; what was placed there moves to where it was."""
    world = services.session.world
    expects = _expected(world, element, seen)
    with writing(world, caller, reason or f"removes {element}", expects) as tx:
        tx.remove(element)
    return written(world, tx)


@router.put(
    "/elements/{element}/relations/{relation}/{other}",
    summary="State a relation",
    dependencies=[needs(Role.OPERATOR)],
    responses=_WRITES,
)
def state_relation(
    element: ElementPath,
    relation: NamePath,
    other: ElementPath,
    services: ServicesDep,
    caller: CallerDep,
    seen: VersionDep,
    response: Response,
    reason: WhyQuery = "",
) -> Written:
    """States that the first element has the relation to the second; a placement moves its element."""
    world = services.session.world
    expects = _expected(world, element, seen)
    with writing(world, caller, reason or f"states {element} {relation} {other}", expects) as tx:
        tx.relate(element, relation, other)
    _tag(world, element, response)
    return written(world, tx)


@router.delete(
    "/elements/{element}/relations/{relation}/{other}",
    summary="Take back a relation",
    dependencies=[needs(Role.OPERATOR)],
    responses=_WRITES,
)
def take_back_relation(
    element: ElementPath,
    relation: NamePath,
    other: ElementPath,
    services: ServicesDep,
    caller: CallerDep,
    seen: VersionDep,
    response: Response,
    reason: WhyQuery = "",
) -> Written:
    """Takes back a stated relation; not a placement, for everything that is really there is somewhere."""
    world = services.session.world
    expects = _expected(world, element, seen)
    with writing(world, caller, reason or f"takes back {element} {relation} {other}", expects) as tx:
        tx.unrelate(element, relation, other)
    _tag(world, element, response)
    return written(world, tx)


def _tag(world: World, element: str, response: Response) -> None:
    view = world.snapshot()
    if view.has(element):  # somebody may have removed it in this moment
        response.headers["ETag"] = etag(view.stamp(element).change)


def _expected(world: World, element: str, seen: str | None) -> dict[str, int]:
    """Returns the version of an element that the caller has seen, for the transaction to check again."""
    with found():
        now = world.stamp(element).change
    require_version(seen, now)
    version = expected_version(seen)
    return {} if version is None else {element: version}
