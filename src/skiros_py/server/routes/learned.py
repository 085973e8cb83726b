"""Routes: what robots were taught."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Request, Response

from skiros_py.api import world as api
from skiros_py.server.access.roles import Engineer, Viewer
from skiros_py.server.problems import NEEDS_VERSION, SeenDep, topic_router
from skiros_py.server.routes.scenes import TRIPLES, sent_triples
from skiros_py.server.routes.world import Cursor, ElementPath, Limit, WhyQuery
from skiros_py.station.requests import Sent

router = topic_router("learned")


@router.get("/learned")
def list_learned(act: Viewer, limit: Limit = 100, cursor: Cursor = None) -> api.LearnedPage:
    """List learned concepts.

    Lists the concepts taught to robots, which persist beyond this scene, in the order of ids.
    """
    return act.station.world.learned(limit, cursor or "")


@router.post("/learned", status_code=201)
def teach_concept(act: Engineer, new: api.NewElement) -> api.Written:
    """Add a learned concept.

    Adds a learned concept of a class, or like an element of the scene; its id is `ids.new` of the response.
    """
    written = act.station.world.teach(new, act.author)
    act.locate("elements", written.ids["new"])
    return written


async def _sent(request: Request) -> Sent:
    return sent_triples(request, await request.body())


@router.post("/learned/import", openapi_extra={"requestBody": {"required": True, "content": TRIPLES}})
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


@router.patch("/learned/{element}", responses=NEEDS_VERSION)
def change_learned(act: Engineer, element: ElementPath, patch: api.ElementPatch, seen: SeenDep) -> api.Written:
    """Change a learned concept.

    Changes label and values of a learned concept as one change; `If-Match` names the version that was seen.
    """
    return act.station.world.edit_learned(element, patch, seen, act.author)


@router.delete("/learned/{element}", responses=NEEDS_VERSION)
def forget_learned(act: Engineer, element: ElementPath, seen: SeenDep, reason: WhyQuery = "") -> api.Written:
    """Forget a learned concept.

    Deletes a learned concept with its parts; an undo restores it.
    """
    return act.station.world.forget(element, seen, act.author, reason)


@router.get(
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
