"""Routes: learned."""

from __future__ import annotations

from fastapi import APIRouter, Response

from skiros_py.api.world import LearnedPage, Written
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, SeenDep
from skiros_py.server.routes.parameters import Cursor, ElementPath, Limit, WhyQuery
from skiros_py.server.services import StationDep

router = APIRouter(tags=["learned"])


@router.get("/learned", summary="List what robots were taught", dependencies=[needs(Role.VIEWER)])
def list_learned(station: StationDep, limit: Limit = 100, cursor: Cursor = None) -> LearnedPage:
    """Lists what robots were taught and keep beyond this scene, in the order of ids."""
    return station.world.learned(limit, cursor or "")


@router.delete(
    "/learned/{element}", summary="Forget something", dependencies=[needs(Role.ENGINEER)], responses=NEEDS_VERSION
)
def forget_learned(
    element: ElementPath, station: StationDep, caller: CallerDep, seen: SeenDep, reason: WhyQuery = ""
) -> Written:
    """Forgets something with its pieces; an undo brings it back."""
    return station.world.forget(element, seen, caller.author, reason)


@router.get(
    "/learned.ttl",
    summary="Read what robots were taught as Turtle",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses={200: {"content": {"text/turtle": {"schema": {"type": "string"}}}}},
)
def export_learned(station: StationDep) -> Response:
    """Writes everything that was learned as the text of a file.

    Another robot knows it from the start when the file lies in its new data directory as learned.ttl.
    """
    return Response(station.world.learned_turtle(), media_type="text/turtle; charset=utf-8")
