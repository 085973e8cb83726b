"""Routes: scenes that can be loaded, the current one, and the simulation of it."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError

from skiros_py.api import scenes as api
from skiros_py.server.access.roles import Engineer, Operator, Viewer
from skiros_py.server.problems import NEEDS_VERSION, Problem, SeenDep, etag, tagged

router = APIRouter(tags=["scenes"])

TURTLE = "text/turtle"

SceneName = Annotated[
    str, Path(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$", description="Name of the scene.", examples=["kitting"])
]
Limit = Annotated[int, Query(ge=1, le=1000)]
Cursor = Annotated[str | None, Query(max_length=100)]


# ---------------------------------------------------------------- scenes that can be loaded


@router.get("/scenes")
def list_scenes(act: Viewer, limit: Limit = 100, cursor: Cursor = None) -> api.Scenes:
    """List scenes.

    Lists the scenes installed with packages and those saved here, by name.
    """
    return act.station.scenes.all(limit, cursor or "")


@router.post("/scenes", status_code=201, responses=NEEDS_VERSION | tagged(201))
def save_scene(act: Operator, wanted: api.SaveScene, seen: SeenDep) -> api.SceneEntry:
    """Save the current scene.

    Saves the current beliefs as a scene, atomically: all elements and the goals.

    To replace a saved scene of that name, `If-Match` names the version that was seen.
    """
    act.locate("scenes", wanted.name)
    return act.tagged(*act.station.scenes.save(wanted.name, seen))


@router.get("/scenes/{name}", responses=tagged())
def get_scene_file(act: Viewer, name: SceneName) -> api.Scene:
    """Get a scene.

    Describes a scene without loading it.
    """
    return act.tagged(act.station.scenes.get(name))


@router.delete("/scenes/{name}", status_code=204)
def delete_scene(act: Operator, name: SceneName, seen: SeenDep) -> None:
    """Delete a saved scene.

    Deletes a saved scene; the current beliefs do not change. With `If-Match`, only if that is its version.
    """
    act.station.scenes.delete(name, seen)


# ---------------------------------------------------------------- the current scene


@router.get("/scene", responses=tagged())
def get_scene(act: Viewer) -> api.PresentScene:
    """Get the current scene.

    Returns which scene was loaded last, what it contains now, and whether it was changed since.
    """
    return act.tagged(act.station.scenes.present())


async def _wanted(request: Request) -> tuple[str, bytes]:
    """Returns the name of the scene to be loaded, or its text: one of the two is empty."""
    body = await request.body()
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind == TURTLE:
        return "", body
    if kind != "application/json":
        raise Problem(
            415,
            "UnsupportedMediaType",
            f'send a name as application/json, {{"name": "kitting"}}, or a scene as {TURTLE}',
        )
    try:
        return api.LoadScene.model_validate_json(body).name, b""
    except ValidationError as error:
        wrong: list[Any] = [{**one, "loc": ("body", *one["loc"])} for one in error.errors(include_url=False)]
        raise RequestValidationError(wrong) from None


_LOAD_BODY = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {
                "schema": api.LoadScene.model_json_schema(),
                "examples": {"name": {"value": {"name": "kitting"}}},
            },
            TURTLE: {"schema": {"type": "string"}, "example": "scene:this a sk:Scene ."},
        },
    }
}


@router.put("/scene", openapi_extra=_LOAD_BODY, responses=NEEDS_VERSION | tagged())
def load_scene(
    act: Operator, wanted: Annotated[tuple[str, bytes], Depends(_wanted)], seen: SeenDep
) -> api.PresentScene:
    """Load a scene.

    Replaces the current scene by another one, named or sent as Turtle. Learned concepts are kept.

    The new scene is read and checked first; if there is any fault, the current one is kept. Nothing is fetched from the
    network. Then robots, skill managers and bodies are brought up, and the response is sent when that is done; other
    requests wait meanwhile, jobs stay in the queue. The station must be idle. `If-Match` names the version of the world
    that was seen.
    """
    return act.tagged(act.station.scenes.load(*wanted, seen, act.author))


@router.get(
    "/scene.ttl",
    response_class=Response,
    responses={200: {"description": "The scene.", "content": {TURTLE: {}}, **tagged()[200]}},
)
def get_scene_turtle(act: Viewer) -> Response:
    """Export the current scene as Turtle.

    Returns the current beliefs as a scene file; equal contents give equal files.
    """
    text, version = act.station.scenes.turtle()
    return Response(text, media_type=TURTLE, headers={"ETag": etag(version)})


@router.get("/scene/diff")
def get_scene_difference(
    act: Viewer,
    with_: Annotated[str, Query(alias="with", pattern="^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$", examples=["kitting"])],
    limit: Limit = 100,
    cursor: Annotated[str | None, Query(pattern=r"^\d{1,9}$")] = None,
) -> api.SceneDifference:
    """Compare with another scene.

    Returns the edits that turn another scene into the current one.

    Parameters:
        with: Name of the other scene.
        cursor: `next` of the previous page.
    """
    return act.station.scenes.difference(with_, int(cursor or 0), limit)


simulation_router = APIRouter(prefix="/simulation", tags=["simulation"])

BodyId = Annotated[str, Path(max_length=200, description="Id of the body.", examples=["starter_1"])]
_COORDINATES = r"^-?\d{1,4}(\.\d{1,9})?(,-?\d{1,4}(\.\d{1,9})?){2}$"
_PICTURE: dict[int | str, dict[str, Any]] = {200: {"description": "The picture.", "content": {"image/png": {}}}}


@simulation_router.get("")
def get_simulation(act: Viewer) -> api.SimulationState:
    """Get the state of the simulation.

    Returns which driver is used, whether simulated time advances and how fast, and what waits for a reset.
    """
    return act.station.simulation.state()


@simulation_router.get("/bodies", openapi_extra={"x-truth": True})
def list_bodies(act: Viewer) -> api.Bodies:
    """List the true poses of bodies.

    Lists the bodies with their true poses, for people only: robots have no access to them.
    """
    return act.station.simulation.true_bodies()


@simulation_router.put("/bodies/{body}/pose", status_code=204)
def move_body(act: Engineer, body: BodyId, pose: api.BodyPose) -> None:
    """Move a body.

    Moves a body, and brings it to rest. No robot is informed: it has to notice, as if a person had moved it.
    """
    act.station.simulation.move(body, pose)


@simulation_router.delete("/bodies/{body}", status_code=204)
def remove_body(act: Engineer, body: BodyId) -> None:
    """Remove a body.

    Removes a body. No robot is informed; a reset restores it where it is believed to be.
    """
    act.station.simulation.remove(body)


@simulation_router.post("/reset")
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


@simulation_router.put("/pace")
def set_pace(act: Engineer, wanted: api.NewPace) -> api.Pace:
    """Set the pace.

    Changes the speed of simulated time, if the server was started with a pace and not in lockstep.
    """
    return api.Pace(pace=act.station.simulation.set_pace(wanted.pace))


@simulation_router.get("/picture", response_class=Response, responses=_PICTURE)
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
