"""Route: the world as it is seen."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Response

from skiros_py.api.view import WorldView
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.services import StationDep

router = APIRouter(tags=["world"])

_TAG = {"description": "Version of the view, for If-None-Match.", "schema": {"type": "string"}}
_ANSWERS: dict[int | str, dict[str, Any]] = {
    200: {"headers": {"ETag": _TAG}},
    304: {"description": "Nothing changed since the view of If-None-Match.", "headers": {"ETag": _TAG}},
}
_Id = Annotated[str, Query(max_length=300)]


@router.get(
    "/view",
    summary="Read what there is to be seen",
    dependencies=[needs(Role.VIEWER)],
    response_model=WorldView,
    responses=_ANSWERS,
)
def read_view(
    station: StationDep,
    element: Annotated[
        list[_Id] | None,
        Query(
            max_length=100,
            description="Only these elements, with what moves or is gone with them; everything where left out.",
            examples=[["kit_1"]],
        ),
    ] = None,
    if_none_match: Annotated[str | None, Header(max_length=1000, description="ETag of the view that is known.")] = None,
) -> Response:
    """Tells where everything is believed to be, and what it looks like: boxes and cylinders.

    Read everything once; then follow the events of the world, and read anew the elements that they name. What is on a
    robot's base is told in the frame of that base, and what a gripper holds in that of the tool: where these are is
    told by `/state` and its stream from moment to moment.
    """
    tag = f'"{station.world.view_tag()}"'
    if _knows(if_none_match, tag):
        return Response(status_code=304, headers={"ETag": tag})
    # Made into text at once: what was checked when it was made is not checked again.
    text = station.world.view(element).model_dump_json(by_alias=True)
    return Response(text, media_type="application/json", headers={"ETag": tag})


def _knows(given: str | None, tag: str) -> bool:
    return given is not None and tag in {one.strip().removeprefix("W/") for one in given.split(",")}
