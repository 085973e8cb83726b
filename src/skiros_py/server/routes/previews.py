"""Routes: previews, what would be done for a goal."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import quote

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.goals import GoalOrder
from skiros_py.api.previews import AppliedRepair, Preview, PreviewPage
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.services import StationDep

router = APIRouter(tags=["previews"])

_NEEDS = [needs(Role.OPERATOR, mes=True)]
PreviewId = Annotated[str, Path(min_length=1, max_length=20, description="Id of the preview.", examples=["1"])]


@router.post("/previews", summary="Plan without doing", status_code=202, dependencies=_NEEDS)
def ask_preview(order: GoalOrder, station: StationDep, response: Response) -> Preview:
    """Begins to plan for a goal from what is believed now; nothing is done. At most two are planned at a time."""
    preview = station.previews.ask(order)
    response.headers["Location"] = f"/api/v1/previews/{quote(preview.id, safe='')}"
    response.headers["Retry-After"] = "1"
    return preview


@router.get("/previews", summary="List previews", dependencies=_NEEDS)
def list_previews(station: StationDep) -> PreviewPage:
    """Lists the previews that are kept, the latest first: a hundred, and none over a restart or another scene."""
    return station.previews.all()


@router.get("/previews/{id}", summary="Look at a preview", dependencies=_NEEDS)
def get_preview(
    id: PreviewId,  # noqa: A002 - the name in the address
    station: StationDep,
    wait: Annotated[float, Query(ge=0.0, le=30.0, description="How long to wait for the answer [s].")] = 0.0,
) -> Preview:
    """Shows the plan with order and planned starts; or why there is none, and what would help."""
    return station.previews.get(id, wait)


@router.post("/previews/{id}/repairs/{number}/apply", summary="Make a repair", dependencies=[needs(Role.OPERATOR)])
def apply_repair(
    id: PreviewId,  # noqa: A002 - the name in the address
    number: Annotated[int, Path(ge=0, le=1000, description="Number of the repair.", examples=[0])],
    station: StationDep,
    caller: CallerDep,
) -> AppliedRepair:
    """Makes what a repair changes in the world, as one transaction by the caller; the goal is left to them."""
    return station.previews.apply_repair(id, number, caller.author)
