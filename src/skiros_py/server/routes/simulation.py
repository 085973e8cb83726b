"""Routes: the simulation of the current scene."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Path, Query, Response

from skiros_py.api import scenes as api
from skiros_py.server.access.roles import Engineer, Viewer
from skiros_py.server.problems import topic_router

router = topic_router("simulation", "/simulation")

BodyId = Annotated[str, Path(alias="element", max_length=200, description="Id of the body.", examples=["starter_1"])]
_COORDINATES = r"^-?\d{1,4}(\.\d{1,9})?(,-?\d{1,4}(\.\d{1,9})?){2}$"
_PICTURE: dict[int | str, dict[str, Any]] = {200: {"description": "The picture.", "content": {"image/png": {}}}}


@router.get("")
def get_simulation(act: Viewer) -> api.SimulationState:
    """Get the state of the simulation.

    Returns which driver is used, whether simulated time advances and how fast, and what waits for a reset.
    """
    return act.station.simulation.state()


@router.get("/bodies", openapi_extra={"x-truth": True})
def list_bodies(act: Viewer) -> api.Bodies:
    """List the true poses of bodies.

    Lists the bodies with their true poses, for people only: robots have no access to them.
    """
    return act.station.simulation.true_bodies()


@router.put("/bodies/{element}/pose", status_code=204)
def move_body(act: Engineer, body: BodyId, pose: api.BodyPose, check: bool = False) -> None:
    """Move a body.

    Moves a body, and brings it to rest. No robot is informed: it has to notice, as if a person had moved it.

    409 if it would be inside another body there: `hits` are the depths [m], by id.

    Parameters:
        check: Only check whether it has room there.
    """
    act.station.simulation.move(body, pose, check=check)


@router.delete("/bodies/{element}", status_code=204)
def remove_body(act: Engineer, body: BodyId) -> None:
    """Remove a body.

    Removes a body. No robot is informed; a reset restores it where it is believed to be.
    """
    act.station.simulation.remove(body)


@router.post("/reset")
def reset_simulation(
    act: Engineer,
    force: bool = False,
) -> api.SimulationState:
    """Reset the simulation.

    Brings everything up again: robots at the start poses of the scene, bodies where they are believed to be.

    The response is sent when the station is up again. It also helps after a fault of the control cycle; a halt remains.

    Parameters:
        force: Stop everything that is running first; its jobs wait for a person.
    """
    return act.station.simulation.reset(force=force)


@router.put("/pace")
def set_pace(act: Engineer, wanted: api.NewPace) -> api.Pace:
    """Set the pace.

    Changes the speed of simulated time, if the server was started with a pace and not in lockstep.
    """
    return api.Pace(pace=act.station.simulation.set_pace(wanted.pace))


@router.get("/picture", response_class=Response, responses=_PICTURE)
def get_picture(
    act: Viewer,
    eye: Annotated[str, Query(pattern=_COORDINATES)] = "3.5,-3.5,3",
    target: Annotated[str, Query(pattern=_COORDINATES)] = "0.5,0,0.3",
    width: Annotated[int, Query(ge=16, le=1280)] = 640,
    height: Annotated[int, Query(ge=16, le=960)] = 480,
) -> Response:
    """Render a picture of the scene.

    Renders the true state of the scene as PNG. One at a time: 503 says when to retry.

    Parameters:
        eye: Position of the observer: x,y,z in the map [m].
        target: Point at which the observer looks: x,y,z in the map [m].
        width: Width [px].
        height: Height [px].
    """
    png = act.station.simulation.picture(_point(eye), _point(target), width, height)
    return Response(png, media_type="image/png", headers={"Cache-Control": "no-store"})


def _point(text: str) -> tuple[float, float, float]:
    x, y, z = map(float, text.split(","))
    return x, y, z
