"""Routes: the simulation, apart from what robots believe."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.simulation import Bodies, BodyPose, NewPace, Pace, SimulationState
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.services import StationDep

router = APIRouter(prefix="/simulation", tags=["simulation"])

BodyId = Annotated[str, Path(max_length=200, description="Id of the body.", examples=["starter_1"])]
_COORDINATES = r"^-?\d{1,4}(\.\d{1,9})?(,-?\d{1,4}(\.\d{1,9})?){2}$"
_PICTURE: dict[int | str, dict[str, Any]] = {200: {"description": "The picture.", "content": {"image/png": {}}}}


@router.get("", summary="How the simulation goes on", dependencies=[needs(Role.VIEWER)])
def get_simulation(station: StationDep) -> SimulationState:
    """Returns what is behind the robots, whether time goes on and how fast, and what waits for a reset."""
    return station.simulation.state()


@router.get(
    "/bodies",
    summary="Where everything really is",
    dependencies=[needs(Role.VIEWER)],
    openapi_extra={"x-truth": True},
)
def list_bodies(station: StationDep) -> Bodies:
    """Lists the bodies with their true poses. This is for people who watch: no robot learns it."""
    return station.simulation.true_bodies()


@router.put("/bodies/{body}/pose", status_code=204, summary="Move a body", dependencies=[needs(Role.ENGINEER)])
def move_body(body: BodyId, pose: BodyPose, station: StationDep) -> None:
    """Puts a body somewhere else, at rest. No robot is told: it has to find out, as if somebody had done it by hand."""
    station.simulation.move(body, pose)


@router.delete("/bodies/{body}", status_code=204, summary="Take a body away", dependencies=[needs(Role.ENGINEER)])
def remove_body(body: BodyId, station: StationDep) -> None:
    """Takes a body away. No robot is told; a reset brings it back where it is believed to be."""
    station.simulation.remove(body)


@router.post("/reset", summary="Reset the simulation", dependencies=[needs(Role.ENGINEER)])
def reset_simulation(
    station: StationDep,
    force: Annotated[bool, Query(description="Stop first whatever is under way; its jobs wait for a person.")] = False,
) -> SimulationState:
    """Brings everything up again: robots where the scene puts them, bodies as they are believed, beliefs as they are.

    It is answered when the station is up again. This also helps where the control cycle broke. Where everything was
    halted, it still is.
    """
    return station.simulation.reset(force=force)


@router.put("/pace", summary="Go on faster or slower", dependencies=[needs(Role.ENGINEER)])
def set_pace(wanted: NewPace, station: StationDep) -> Pace:
    """Changes how fast simulated time goes on, where the server was started with a pace and not in lockstep."""
    return Pace(pace=station.simulation.set_pace(wanted.pace))


@router.get(
    "/picture",
    summary="A picture of the scene",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses=_PICTURE,
)
def get_picture(
    station: StationDep,
    eye: Annotated[
        str, Query(pattern=_COORDINATES, description="Where the observer is: x,y,z in the map [m].")
    ] = "3.5,-3.5,3",
    target: Annotated[
        str, Query(pattern=_COORDINATES, description="Where the observer looks: x,y,z [m].")
    ] = "0.5,0,0.3",
    width: Annotated[int, Query(ge=16, le=1280, description="[px].")] = 640,
    height: Annotated[int, Query(ge=16, le=960, description="[px].")] = 480,
) -> Response:
    """Draws the scene as it really is now, as PNG. One at a time: 503 says when to ask again."""
    png = station.simulation.picture(_point(eye), _point(target), width, height)
    return Response(png, media_type="image/png", headers={"Cache-Control": "no-store"})


def _point(text: str) -> tuple[float, float, float]:
    x, y, z = map(float, text.split(","))
    return x, y, z
