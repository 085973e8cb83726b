"""Routes: elements, and concepts that robots were taught."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Query, Request, Response

from skiros_py.api import world as api
from skiros_py.server.access.roles import Act, Engineer, Operator, Viewer
from skiros_py.server.problems import NEEDS_VERSION, SeenDep, tagged, topic_router
from skiros_py.server.routes.scenes import TRIPLES, sent_triples
from skiros_py.server.routes.world import (
    ChangeLimit,
    Cursor,
    ElementPath,
    Limit,
    NamePath,
    WhyQuery,
    number_cursor,
)
from skiros_py.station.requests import Sent

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


learned_router = topic_router("learned")

Name = Annotated[str, Query(max_length=300)]


@learned_router.get("/learned")
def list_learned(act: Viewer, limit: Limit = 100, cursor: Cursor = None) -> api.LearnedPage:
    """List learned concepts.

    Lists the concepts taught to robots, which persist beyond this scene, in the order of ids.
    """
    return act.station.world.learned(limit, cursor or "")


@learned_router.post("/learned", status_code=201)
def teach_concept(act: Engineer, new: api.NewElement) -> api.Written:
    """Add a learned concept.

    Adds a learned concept of a class, or like an element of the scene; its id is `ids.new` of the response.
    """
    written = act.station.world.teach(new, act.author)
    act.locate("elements", written.ids["new"])
    return written


async def _sent(request: Request) -> Sent:
    return sent_triples(request, await request.body())


@learned_router.post("/learned/import", openapi_extra={"requestBody": {"required": True, "content": TRIPLES}})
def import_concepts(
    act: Engineer, sent: Annotated[Sent, Depends(_sent)], replace: bool = False, reason: WhyQuery = ""
) -> api.Written:
    """Import learned concepts.

    Adds the learned concepts of a file, as one change that an undo reverts; those that exist already are left.

    The file may describe individuals of `learned:` only; nothing is fetched from the network.

    Parameters:
        replace: Replace concepts that are different here, with their parts and relations; else they are refused.
    """
    return act.station.world.import_learned(sent, act.author, reason, replace=replace)


@learned_router.post("/learned/forget")
def forget_costs(act: Engineer, skill: Name = "", robot: Name = "", place: Name = "", kind: Name = "") -> api.Written:
    """Forget what was learned from runs.

    Deletes what was learned about durations and success rates, as one change that an undo reverts; the next plan does
    not consider it. Taught concepts are kept.

    Parameters:
        skill: Only about this skill.
        robot: Only about this robot.
        place: Only about this place.
        kind: Only about parts of this class.
    """
    return act.station.world.forget_costs(skill, robot, place, kind, act.author)


@learned_router.patch("/learned/{element}", responses=NEEDS_VERSION)
def change_learned(act: Engineer, element: ElementPath, patch: api.ElementPatch, seen: SeenDep) -> api.Written:
    """Change a learned concept.

    Changes label and values of a learned concept as one change; `If-Match` names the version that was seen.
    """
    return act.station.world.edit_learned(element, patch, seen, act.author)


@learned_router.delete("/learned/{element}", responses=NEEDS_VERSION)
def forget_learned(act: Engineer, element: ElementPath, seen: SeenDep, reason: WhyQuery = "") -> api.Written:
    """Forget a learned concept.

    Deletes a learned concept with its parts; an undo restores it.
    """
    return act.station.world.forget(element, seen, act.author, reason)


@learned_router.get(
    "/learned.ttl",
    response_class=Response,
    responses={200: {"content": {"text/turtle": {"schema": {"type": "string"}}}}},
)
def export_learned(act: Viewer) -> Response:
    """Export learned concepts as Turtle.

    Returns all learned concepts as the text of a Turtle file.

    A new data directory that contains this file as learned.ttl starts with them.
    """
    return Response(act.station.world.learned_turtle(), media_type="text/turtle; charset=utf-8")
