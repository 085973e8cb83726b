"""Routes: elements."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query

from skiros_py.api import world as api
from skiros_py.server.access.roles import Act, Operator, Viewer
from skiros_py.server.problems import NEEDS_VERSION, SeenDep, tagged, topic_router
from skiros_py.server.routes.world import (
    ChangeLimit,
    Cursor,
    ElementPath,
    Limit,
    NamePath,
    WhyQuery,
    number_cursor,
)

router = topic_router("elements")

_LATEST = 2**62
_WRITES = NEEDS_VERSION | tagged()


# ------------------------------------------------------------------ reading


@router.get("/elements")
def list_elements(
    act: Viewer,
    class_: Annotated[str, Query(alias="class", min_length=1, max_length=300)] = api.EVERYTHING,
    label: Annotated[str | None, Query(max_length=1000)] = None,
    text: Annotated[str | None, Query(max_length=200)] = None,
    place: Annotated[str | None, Query(max_length=300)] = None,
    abstract: bool = False,
    limit: Limit = 100,
    cursor: Cursor = None,
) -> api.ElementPage:
    """List elements.

    Lists elements in the order of their ids; all conditions must be met.

    Parameters:
        class: Only this class and its subclasses.
        label: Only with this label.
        text: Only with this text in id, label or class; case is ignored.
        place: Only elements placed directly here, by any relation.
        abstract: Elements of the ontology and learned concepts, instead of the scene.
    """
    return act.station.elements.all(
        class_, label=label, text=text, place=place, abstract=abstract, limit=limit, after=cursor or ""
    )


@router.get("/elements/{element}", responses=tagged())
def read_element(
    act: Viewer,
    element: ElementPath,
    computed: Annotated[list[api.Name], Query(max_length=50)] = [],  # noqa: B006  FastAPI copies it
) -> api.ElementDetails:
    """Get an element.

    Returns its values with their origin, its relations in both directions, and its pose.

    The ETag is used with `If-Match` to change the element.

    Parameters:
        computed: Computed relations to evaluate, such as sk:near; "all" for all of them.
    """
    return act.tagged(act.station.elements.get(element, computed))


@router.get("/elements/{element}/relations")
def list_relations(
    act: Viewer,
    element: ElementPath,
    relation: Annotated[str | None, Query(max_length=300)] = None,
    limit: Limit = 100,
    cursor: Cursor = None,
) -> api.RelationPage:
    """List the relations of an element.

    Lists the relations of an element, in both directions, sorted.

    Parameters:
        relation: Only this relation and its sub-relations; may be a computed one.
    """
    return act.station.elements.relations(element, relation, number_cursor(cursor), limit)


@router.get("/elements/{element}/history")
def read_element_history(
    act: Viewer, element: ElementPath, newest_first: bool = True, limit: ChangeLimit = 100, cursor: Cursor = None
) -> api.ChangePage:
    """Get the history of an element.

    Lists the changes of an element, which may have been removed since, with their authors and reasons.

    Parameters:
        newest_first: From the newest change backwards.
    """
    start = number_cursor(cursor, _LATEST if newest_first else 0)
    return act.station.elements.history(element, start, limit, newest_first=newest_first)


# ------------------------------------------------------------------ writing


@router.post("/elements", status_code=201, responses=tagged(201))
def add_element(act: Operator, new: api.NewElement) -> api.ElementDetails:
    """Add an element.

    Adds an element with its values, its placement and its relations, as one change.

    While the station is working, only beliefs change.
    """
    element = act.station.elements.add(new, act.author)
    act.locate("elements", element.id)
    return act.tagged(element)


@router.patch("/elements/{element}", responses=_WRITES)
def change_element(act: Operator, element: ElementPath, patch: api.ElementPatch, seen: SeenDep) -> api.ElementDetails:
    """Change an element.

    Changes label, values and placement of an element as one change; `If-Match` names the version that was seen.
    """
    return act.tagged(act.station.elements.change(element, patch, seen, act.author))


@router.delete("/elements/{element}", responses=NEEDS_VERSION)
def remove_element(act: Operator, element: ElementPath, seen: SeenDep, reason: WhyQuery = "") -> api.Written:
    """Remove an element.

    Removes an element with its parts; things placed there move to where the element was.
    """
    return act.station.elements.remove(element, seen, act.author, reason)


@router.put("/elements/{element}/relations/{relation}/{other}", responses=_WRITES)
def state_relation(
    act: Operator, element: ElementPath, relation: NamePath, other: ElementPath, seen: SeenDep, reason: WhyQuery = ""
) -> api.Written:
    """State a relation.

    States that the first element has the relation to the second; a placement moves its element.
    """
    written = act.station.elements.relate(element, relation, other, seen, act.author, reason)
    _tag(act, act.station.elements.version(element))
    return written


@router.delete("/elements/{element}/relations/{relation}/{other}", responses=_WRITES)
def take_back_relation(
    act: Operator, element: ElementPath, relation: NamePath, other: ElementPath, seen: SeenDep, reason: WhyQuery = ""
) -> api.Written:
    """Remove a relation.

    Removes a stated relation; placements cannot be removed, since every element has a place.
    """
    written = act.station.elements.relate(element, relation, other, seen, act.author, reason, holds=False)
    _tag(act, act.station.elements.version(element))
    return written


def _tag(act: Act, version: int | None) -> None:
    if version is not None:  # somebody may have removed it in this moment
        act.tag(version)
