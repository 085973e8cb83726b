"""Routes: models of robots, as they are drawn."""

from __future__ import annotations

import math
from typing import Annotated, Any

from fastapi import APIRouter, Path, Response

from skiros_py.errors import Busy
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.services import StationDep

router = APIRouter(tags=["robots"])

_Id = Annotated[str, Path(max_length=200)]
_MeshName = Annotated[str, Path(max_length=200, description="As the model names it.")]
_FOREVER = {"Cache-Control": "private, max-age=31536000, immutable"}
"""What is named by its content never changes."""
_URDF: dict[int | str, dict[str, Any]] = {
    200: {"description": "The model.", "content": {"application/xml": {}}},
    202: {"description": "It is being made: ask again after `Retry-After` seconds."},
}
_STL: dict[int | str, dict[str, Any]] = {200: {"description": "The mesh.", "content": {"model/stl": {}}}}


@router.get(
    "/robots/{id}/model",
    summary="Read a robot's model",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses=_URDF,
)
def get_robot_model(id: _Id, station: StationDep) -> Response:  # noqa: A002 - as the address says it
    """Returns what a robot looks like and how it moves, as URDF: links, joints, visible shapes with their colours.

    Files of meshes are named from the address of the model, are binary STL, and have few triangles. The description of
    the robot says which joints stand where. The first time it may take some seconds; 202 without content says when to
    ask again.
    """
    try:
        return Response(station.robots.model(id).urdf, media_type="application/xml")
    except Busy as busy:
        return Response(status_code=202, headers={"Retry-After": str(math.ceil(busy.retry_after))})


@router.get(
    "/robots/{id}/model/meshes/{name}",
    summary="Read a mesh of a robot's model",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses=_STL,
)
def get_robot_mesh(id: _Id, name: _MeshName, station: StationDep) -> Response:  # noqa: A002
    """Gives one of the meshes that the model names, as binary STL [m]; nothing else."""
    return Response(station.robots.mesh(id, name), media_type="model/stl", headers=_FOREVER)
