"""Routes: elements."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import quote

from fastapi import APIRouter, Query, Response

from skiros_py.api.world import (
    EVERYTHING,
    ChangePage,
    ElementDetails,
    ElementPage,
    ElementPatch,
    Name,
    NewElement,
    RelationPage,
    Written,
)
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import NEEDS_VERSION, SeenDep, etag, tagged, with_etag
from skiros_py.server.routes.world import (
    ChangeLimit,
    Cursor,
    ElementPath,
    Limit,
    NamePath,
    WhyQuery,
    number_cursor,
)
from skiros_py.server.services import StationDep

router = APIRouter(tags=["elements"])

_LATEST = 2**62
_WRITES = NEEDS_VERSION | tagged()


# ------------------------------------------------------------------ reading


@router.get("/elements", dependencies=[needs(Role.VIEWER)])
def list_elements(
    station: StationDep,
    class_: Annotated[
        str, Query(alias="class", min_length=1, max_length=300, description="Of this class or one below.")
    ] = EVERYTHING,
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
    """List elements.

    Lists elements in the order of their ids; all conditions must be met.
    """
    return station.elements.all(
        class_, label=label, text=text, place=place, abstract=abstract, limit=limit, after=cursor or ""
    )


@router.get("/elements/{element}", dependencies=[needs(Role.VIEWER)], responses=tagged())
def read_element(
    element: ElementPath,
    station: StationDep,
    response: Response,
    computed: Annotated[
        list[Name],
        Query(max_length=50, description='Computed relations to work out, such as sk:near; "all" for all of them.'),
    ] = [],  # noqa: B006  FastAPI copies it
) -> ElementDetails:
    """Read an element.

    Tells its values with their origin, its relations in both directions, and where it is.

    The answer's ETag is what `If-Match` takes when the element is changed.
    """
    return with_etag(station.elements.get(element, computed), response)


@router.get("/elements/{element}/relations", dependencies=[needs(Role.VIEWER)])
def list_relations(
    element: ElementPath,
    station: StationDep,
    relation: Annotated[
        str | None, Query(max_length=300, description="Only of this relation or one below, also a computed one.")
    ] = None,
    limit: Limit = 100,
    cursor: Cursor = None,
) -> RelationPage:
    """List an element's relations.

    Lists what is stated of an element, in both directions, in order.
    """
    return station.elements.relations(element, relation, number_cursor(cursor), limit)


@router.get("/elements/{element}/history", dependencies=[needs(Role.VIEWER)])
def read_element_history(
    element: ElementPath,
    station: StationDep,
    newest_first: Annotated[bool, Query(description="Go back in time.")] = True,
    limit: ChangeLimit = 100,
    cursor: Cursor = None,
) -> ChangePage:
    """Read an element's history.

    Returns which changes touched an element, by whom and why; the element may be gone.
    """
    start = number_cursor(cursor, _LATEST if newest_first else 0)
    return station.elements.history(element, start, limit, newest_first=newest_first)


# ------------------------------------------------------------------ writing


@router.post("/elements", status_code=201, dependencies=[needs(Role.OPERATOR)], responses=tagged(201))
def add_element(new: NewElement, station: StationDep, caller: CallerDep, response: Response) -> ElementDetails:
    """Add an element.

    Adds an element with its values, its place and its relations, all at once.

    While something runs this changes what is believed, nothing else.
    """
    element = station.elements.add(new, caller.author)
    response.headers["Location"] = f"/api/v1/elements/{quote(element.id, safe='')}"
    return with_etag(element, response)


@router.patch("/elements/{element}", dependencies=[needs(Role.OPERATOR)], responses=_WRITES)
def change_element(
    element: ElementPath,
    patch: ElementPatch,
    station: StationDep,
    caller: CallerDep,
    seen: SeenDep,
    response: Response,
) -> ElementDetails:
    """Change an element.

    Changes label, values and place of an element in one transaction; `If-Match` says which version was seen.
    """
    return with_etag(station.elements.change(element, patch, seen, caller.author), response)


@router.delete("/elements/{element}", dependencies=[needs(Role.OPERATOR)], responses=NEEDS_VERSION)
def remove_element(
    element: ElementPath, station: StationDep, caller: CallerDep, seen: SeenDep, reason: WhyQuery = ""
) -> Written:
    """Remove an element.

    Removes an element with its pieces; what was placed there moves to where it was.
    """
    return station.elements.remove(element, seen, caller.author, reason)


@router.put("/elements/{element}/relations/{relation}/{other}", dependencies=[needs(Role.OPERATOR)], responses=_WRITES)
def state_relation(
    element: ElementPath,
    relation: NamePath,
    other: ElementPath,
    station: StationDep,
    caller: CallerDep,
    seen: SeenDep,
    response: Response,
    reason: WhyQuery = "",
) -> Written:
    """State a relation.

    States that the first element has the relation to the second; a placement moves its element.
    """
    written = station.elements.relate(element, relation, other, seen, caller.author, reason)
    _tag(station.elements.version(element), response)
    return written


@router.delete(
    "/elements/{element}/relations/{relation}/{other}", dependencies=[needs(Role.OPERATOR)], responses=_WRITES
)
def take_back_relation(
    element: ElementPath,
    relation: NamePath,
    other: ElementPath,
    station: StationDep,
    caller: CallerDep,
    seen: SeenDep,
    response: Response,
    reason: WhyQuery = "",
) -> Written:
    """Take back a relation.

    Takes back a stated relation; not a placement, for everything that is really there is somewhere.
    """
    written = station.elements.unrelate(element, relation, other, seen, caller.author, reason)
    _tag(station.elements.version(element), response)
    return written


def _tag(version: int | None, response: Response) -> None:
    if version is not None:  # somebody may have removed it in this moment
        response.headers["ETag"] = etag(version)
