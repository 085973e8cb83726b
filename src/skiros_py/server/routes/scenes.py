"""Routes: scenes that can be loaded, the current one, and its simulation."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Depends, Path, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError

from skiros_py.api import scenes as api
from skiros_py.config import SCENE_NAME
from skiros_py.files import RDF_TYPES
from skiros_py.server.access.roles import Engineer, Operator, Viewer
from skiros_py.server.problems import NEEDS_VERSION, Problem, SeenDep, etag, tagged, topic_router
from skiros_py.station.requests import Sent

router = topic_router("scenes")

TURTLE = "text/turtle"
TRIPLES = {media_type: {"schema": {"type": "string"}} for media_type in dict.fromkeys(RDF_TYPES.values())}
"""The content types of files with triples, as in the OpenAPI document."""

SceneName = Annotated[str, Path(pattern=f"^{SCENE_NAME}$", description="Name of the scene.", examples=["kitting"])]
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
def describe_scene(act: Viewer, name: SceneName) -> api.Scene:
    """Describe a scene.

    Describes a scene that can be loaded: its source, contents and goals.
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
def get_scene(act: Viewer) -> api.CurrentScene:
    """Get the current scene.

    Returns which scene was loaded last, what it contains now, and whether it was changed since.
    """
    return act.tagged(act.station.scenes.current())


def sent_triples(request: Request, body: bytes, instead: str = "") -> Sent:
    """Returns a file with triples that was sent.

    Args:
        request: The request.
        body: Its body.
        instead: What else may be sent, for people.

    Raises:
        Problem: It is of another content type (415).
    """
    kind = content_type(request)
    if kind not in TRIPLES:
        raise Problem(415, "UnsupportedMediaType", f"send {instead}triples as {', '.join(TRIPLES)}")
    return Sent(body, kind)


def content_type(request: Request) -> str:
    """Returns the content type of a request, without parameters."""
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()


async def _wanted(request: Request) -> tuple[str, Sent | None]:
    """Returns the name of the scene to be loaded, or the scene that was sent."""
    body = await request.body()
    if content_type(request) != "application/json":
        return "", sent_triples(request, body, 'a name as application/json, {"name": "kitting"}, or ')
    try:
        return api.LoadScene.model_validate_json(body).name, None
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
            **TRIPLES,
            TURTLE: {"schema": {"type": "string"}, "example": "scene:this a sk:Scene ."},
        },
    }
}


@router.put("/scene", openapi_extra=_LOAD_BODY, responses=NEEDS_VERSION | tagged())
def load_scene(
    act: Operator, wanted: Annotated[tuple[str, Sent | None], Depends(_wanted)], seen: SeenDep
) -> api.CurrentScene:
    """Load a scene.

    Replaces the current scene by another one, named or sent as a file. Learned concepts are kept.

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
    with_: Annotated[str, Query(alias="with", pattern=f"^{SCENE_NAME}$", examples=["kitting"])],
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


simulation_router = topic_router("simulation", "/simulation")

BodyId = Annotated[str, Path(alias="element", max_length=200, description="Id of the body.", examples=["starter_1"])]
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


@simulation_router.put("/bodies/{element}/pose", status_code=204)
def move_body(act: Engineer, body: BodyId, pose: api.BodyPose, check: bool = False) -> None:
    """Move a body.

    Moves a body, and brings it to rest. No robot is informed: it has to notice, as if a person had moved it.

    409 if it would be inside another body there: `hits` are the depths [m], by id.

    Parameters:
        check: Only check whether it has room there.
    """
    act.station.simulation.move(body, pose, check=check)


@simulation_router.delete("/bodies/{element}", status_code=204)
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
