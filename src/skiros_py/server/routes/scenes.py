"""Routes: scenes that can be loaded, the current one, and the simulation of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError

from skiros_py.api.scenes import (
    Bodies,
    BodyPose,
    LoadScene,
    NewPace,
    Pace,
    PresentScene,
    SaveScene,
    Scene,
    SceneDifference,
    SceneEntry,
    Scenes,
    SimulationState,
)
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import NEEDS_VERSION, Problem, SeenDep, etag, tagged, with_etag
from skiros_py.server.services import StationDep

router = APIRouter(tags=["scenes"])

TURTLE = "text/turtle"

SceneName = Annotated[
    str, Path(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$", description="Name of the scene.", examples=["kitting"])
]
Limit = Annotated[int, Query(ge=1, le=1000, description="At most so many.")]
Cursor = Annotated[str | None, Query(max_length=100, description="From the page before.")]


# ---------------------------------------------------------------- scenes that can be loaded


@router.get("/scenes", dependencies=[needs(Role.VIEWER)])
def list_scenes(station: StationDep, limit: Limit = 100, cursor: Cursor = None) -> Scenes:
    """Scenes that can be loaded.

    Lists the scenes that came with packages and those saved here, by name.
    """
    return station.scenes.all(limit, cursor or "")


@router.post("/scenes", status_code=201, dependencies=[needs(Role.OPERATOR)], responses=NEEDS_VERSION | tagged(201))
def save_scene(wanted: SaveScene, station: StationDep, seen: SeenDep, response: Response) -> SceneEntry:
    """Save the present scene.

    Saves what is believed now as a scene, whole or not at all; where everything is, and which goals go with it.

    A saved scene of that name is replaced if ``If-Match`` says which version of it you have seen.
    """
    entry, version = station.scenes.save(wanted.name, seen)
    response.headers["Location"] = f"/api/v1/scenes/{wanted.name}"
    response.headers["ETag"] = etag(version)
    return entry


@router.get("/scenes/{name}", dependencies=[needs(Role.VIEWER)], responses=tagged())
def get_scene_file(name: SceneName, station: StationDep, response: Response) -> Scene:
    """One scene that can be loaded.

    Returns what a scene consists of, without loading it.
    """
    scene = station.scenes.get(name)
    response.headers["ETag"] = etag(scene.version)
    return scene


@router.delete("/scenes/{name}", status_code=204, dependencies=[needs(Role.OPERATOR)])
def delete_scene(name: SceneName, station: StationDep, seen: SeenDep) -> None:
    """Remove a saved scene.

    Removes a saved scene; what is believed now stays. With ``If-Match`` only that version of it.
    """
    station.scenes.delete(name, seen)


# ---------------------------------------------------------------- the present scene


@router.get("/scene", dependencies=[needs(Role.VIEWER)], responses=tagged())
def get_scene(station: StationDep, response: Response) -> PresentScene:
    """The present scene.

    Returns which scene was loaded last, what is in it now, and whether that is another by now.
    """
    return with_etag(station.scenes.present(), response)


@dataclass(frozen=True, slots=True)
class _Wish:
    """Which scene shall be loaded: one by its name, or one that was sent."""

    name: str = ""
    turtle: bytes = b""


async def _wish(request: Request) -> _Wish:
    body = await request.body()
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind == TURTLE:
        return _Wish(turtle=body)
    if kind != "application/json":
        raise Problem(
            415,
            "UnsupportedMediaType",
            f'send a name as application/json, {{"name": "kitting"}}, or a scene as {TURTLE}',
        )
    try:
        return _Wish(LoadScene.model_validate_json(body).name)
    except ValidationError as error:
        wrong: list[Any] = [{**one, "loc": ("body", *one["loc"])} for one in error.errors(include_url=False)]
        raise RequestValidationError(wrong) from None


_LOAD_BODY = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {
                "schema": LoadScene.model_json_schema(),
                "examples": {"name": {"value": {"name": "kitting"}}},
            },
            TURTLE: {"schema": {"type": "string"}, "example": "scene:this a sk:Scene ."},
        },
    }
}


@router.put("/scene", dependencies=[needs(Role.OPERATOR)], openapi_extra=_LOAD_BODY, responses=NEEDS_VERSION | tagged())
def load_scene(
    wish: Annotated[_Wish, Depends(_wish)],
    station: StationDep,
    caller: CallerDep,
    seen: SeenDep,
    response: Response,
) -> PresentScene:
    """Load a scene.

    Makes the present scene another one: one by name, or one sent as Turtle. What robots were taught stays.

    It is read and checked beside the present one, which stays where anything is wrong; nothing is fetched from
    anywhere. Then robots, skill managers and bodies are brought up as the new scene has them, and that is answered when
    it is done; other requests wait meanwhile, jobs stay in their queue. Only while nothing is under way.
    ``If-Match`` names the version of the world that you have seen.
    """
    return with_etag(station.scenes.load(wish.name, wish.turtle, seen, caller.author), response)


@router.get(
    "/scene.ttl",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses={200: {"description": "The scene.", "content": {TURTLE: {}}, **tagged()[200]}},
)
def get_scene_turtle(station: StationDep) -> Response:
    """The present scene as Turtle.

    Writes what is believed now as a scene file, in an order that depends on content alone.
    """
    text, version = station.scenes.turtle()
    return Response(text, media_type=TURTLE, headers={"ETag": etag(version)})


@router.get("/scene/diff", dependencies=[needs(Role.VIEWER)])
def get_scene_difference(
    station: StationDep,
    with_: Annotated[
        str,
        Query(
            alias="with",
            pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$",
            description="Name of the other scene.",
            examples=["kitting"],
        ),
    ],
    limit: Limit = 100,
    cursor: Annotated[str | None, Query(pattern=r"^\d{1,9}$", description="From the page before.")] = None,
) -> SceneDifference:
    """What was changed in a scene.

    Returns what makes the present scene of another one.
    """
    return station.scenes.difference(with_, int(cursor or 0), limit)


simulation_router = APIRouter(prefix="/simulation", tags=["simulation"])

BodyId = Annotated[str, Path(max_length=200, description="Id of the body.", examples=["starter_1"])]
_COORDINATES = r"^-?\d{1,4}(\.\d{1,9})?(,-?\d{1,4}(\.\d{1,9})?){2}$"
_PICTURE: dict[int | str, dict[str, Any]] = {200: {"description": "The picture.", "content": {"image/png": {}}}}


@simulation_router.get("", dependencies=[needs(Role.VIEWER)])
def get_simulation(station: StationDep) -> SimulationState:
    """How the simulation goes on.

    Returns what is behind the robots, whether time goes on and how fast, and what waits for a reset.
    """
    return station.simulation.state()


@simulation_router.get("/bodies", dependencies=[needs(Role.VIEWER)], openapi_extra={"x-truth": True})
def list_bodies(station: StationDep) -> Bodies:
    """Where everything really is.

    Lists the bodies with their true poses. This is for people who watch: no robot learns it.
    """
    return station.simulation.true_bodies()


@simulation_router.put("/bodies/{body}/pose", status_code=204, dependencies=[needs(Role.ENGINEER)])
def move_body(body: BodyId, pose: BodyPose, station: StationDep) -> None:
    """Move a body.

    Puts a body somewhere else, at rest. No robot is told: it has to find out, as if somebody had done it by hand.
    """
    station.simulation.move(body, pose)


@simulation_router.delete("/bodies/{body}", status_code=204, dependencies=[needs(Role.ENGINEER)])
def remove_body(body: BodyId, station: StationDep) -> None:
    """Take a body away.

    Takes a body away. No robot is told; a reset brings it back where it is believed to be.
    """
    station.simulation.remove(body)


@simulation_router.post("/reset", dependencies=[needs(Role.ENGINEER)])
def reset_simulation(
    station: StationDep,
    force: Annotated[bool, Query(description="Stop first whatever is under way; its jobs wait for a person.")] = False,
) -> SimulationState:
    """Reset the simulation.

    Brings everything up again: robots where the scene puts them, bodies as they are believed, beliefs as they are.

    It is answered when the station is up again. This also helps where the control cycle broke. Where everything was
    halted, it still is.
    """
    return station.simulation.reset(force=force)


@simulation_router.put("/pace", dependencies=[needs(Role.ENGINEER)])
def set_pace(wanted: NewPace, station: StationDep) -> Pace:
    """Go on faster or slower.

    Changes how fast simulated time goes on, where the server was started with a pace and not in lockstep.
    """
    return Pace(pace=station.simulation.set_pace(wanted.pace))


@simulation_router.get("/picture", dependencies=[needs(Role.VIEWER)], response_class=Response, responses=_PICTURE)
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
    """A picture of the scene.

    Draws the scene as it really is now, as PNG. One at a time: 503 says when to ask again.
    """
    png = station.simulation.picture(_point(eye), _point(target), width, height)
    return Response(png, media_type="image/png", headers={"Cache-Control": "no-store"})


def _point(text: str) -> tuple[float, float, float]:
    x, y, z = map(float, text.split(","))
    return x, y, z
