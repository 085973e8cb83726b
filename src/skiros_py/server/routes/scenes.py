"""Routes: scenes that can be loaded, and the present one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError

from skiros_py.api.scenes import (
    LoadScene,
    PresentScene,
    SaveScene,
    Scene,
    SceneDifference,
    SceneEntry,
    SceneRobot,
    Scenes,
)
from skiros_py.errors import FileError, UsageError
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, VersionDep, etag, expected_version, require_version, tagged
from skiros_py.server.problems import Problem, found
from skiros_py.server.services import Services, ServicesDep
from skiros_py.station.scenes.content import scene_only
from skiros_py.station.scenes.loading import load, require_rest, scene_of
from skiros_py.station.scenes.scenes import SceneFile
from skiros_py.station.scenes.stage import shown
from skiros_py.world.element import is_learned
from skiros_py.world.index import Index
from skiros_py.world.scene import describe
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.vocabulary import ELEMENT, ROBOT

__all__ = ["router"]

router = APIRouter(tags=["scenes"])

TURTLE = "text/turtle"
_UNKNOWN = "UnknownScene"
_SAVED_AS = "saved as"

SceneName = Annotated[
    str, Path(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$", description="Name of the scene.", examples=["kitting"])
]
Limit = Annotated[int, Query(ge=1, le=1000, description="At most so many.")]
Cursor = Annotated[str | None, Query(max_length=100, description="From the page before.")]


# ---------------------------------------------------------------- scenes that can be loaded


@router.get("/scenes", summary="Scenes that can be loaded", dependencies=[needs(Role.VIEWER)])
def list_scenes(services: ServicesDep, limit: Limit = 100, cursor: Cursor = None) -> Scenes:
    """Lists the scenes that came with packages and those saved here, by name."""
    names = [name for name in services.scenes.names() if cursor is None or name > cursor]
    page = names[:limit]
    return Scenes(items=list(_entries(services, page)), next=page[-1] if len(names) > limit else None)


@router.post(
    "/scenes",
    status_code=201,
    summary="Save the present scene",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION | tagged(201),
)
def save_scene(wanted: SaveScene, services: ServicesDep, seen: VersionDep, response: Response) -> SceneEntry:
    """Saves what is believed now as a scene, whole or not at all; where everything is, and which goals go with it.

    A saved scene of that name is replaced if ``If-Match`` says which version of it you have seen.
    """
    version, now = services.session.world.state()
    expects = _expected_file(services, wanted.name, seen)
    with _unwritable():
        file = services.scenes.save(wanted.name, now, expects=expects)
    services.documents.put("scene", _SAVED_AS, {"name": wanted.name, "version": version})
    response.headers["Location"] = f"/api/v1/scenes/{wanted.name}"
    response.headers["ETag"] = etag(file.version)
    return _entry(file)


@router.get(
    "/scenes/{name}", summary="One scene that can be loaded", dependencies=[needs(Role.VIEWER)], responses=tagged()
)
def get_scene_file(name: SceneName, services: ServicesDep, response: Response) -> Scene:
    """Tells what a scene consists of, without loading it."""
    file = _file(services, name)
    with _broken(409, name):
        scene, title = services.stage.read(services.session, file), services.stage.title(file)
    response.headers["ETag"] = etag(file.version)
    return Scene(
        name=name,
        source=_source(file),
        version=file.version,
        title=title,
        elements=len(scene_only(scene).instances(ELEMENT)),
        robots=_robots(scene),
        goals=list(scene.goals),
    )


@router.delete("/scenes/{name}", status_code=204, summary="Remove a saved scene", dependencies=[needs(Role.OPERATOR)])
def delete_scene(name: SceneName, services: ServicesDep, seen: VersionDep) -> None:
    """Removes a saved scene; what is believed now stays. With ``If-Match`` only that version of it."""
    file = _file(services, name)
    if not file.saved:
        raise Problem(409, "SceneInstalled", f"scene '{name}' came with a package, and stays")
    with found(_UNKNOWN):
        services.scenes.remove(name, expects=expected_version(seen))


# ---------------------------------------------------------------- the present scene


@router.get("/scene", summary="The present scene", dependencies=[needs(Role.VIEWER)], responses=tagged())
def get_scene(services: ServicesDep, response: Response) -> PresentScene:
    """Tells which scene was loaded last, what is in it now, and whether that is another by now."""
    return _present(services, response)


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


@router.put(
    "/scene",
    summary="Load a scene",
    dependencies=[needs(Role.OPERATOR)],
    openapi_extra=_LOAD_BODY,
    responses=NEEDS_VERSION | tagged(),
)
def load_scene(
    wish: Annotated[_Wish, Depends(_wish)],
    services: ServicesDep,
    caller: CallerDep,
    seen: VersionDep,
    response: Response,
) -> PresentScene:
    """Makes the present scene another one: one by name, or one sent as Turtle. What robots were taught stays.

    It is read and checked beside the present one, which stays where anything is wrong; nothing is fetched from
    anywhere. Then robots, skill managers and bodies are brought up as the new scene has them, and that is answered when
    it is done; other requests wait meanwhile, jobs stay in their queue. Only while nothing is under way.
    ``If-Match`` names the version of the world that you have seen.
    """
    session = services.session
    require_version(seen, session.world.version)
    services.control.call(require_rest)
    if wish.name:
        file = _file(services, wish.name)
        with _broken(409, wish.name):
            scene = services.stage.read(session, file)
    else:
        with _broken(422, "the scene that was sent"):
            scene = services.stage.read_text(session, wish.turtle)
    services.stage.check(session, scene)
    version = expected_version(seen)
    load(services.control, services.data, scene, wish.name, author=caller.name, holder=caller.holder, seen=version)
    return _present(services, response)


@router.get(
    "/scene.ttl",
    summary="The present scene as Turtle",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses={200: {"description": "The scene.", "content": {TURTLE: {}}, **tagged()[200]}},
)
def get_scene_turtle(services: ServicesDep) -> Response:
    """Writes what is believed now as a scene file, in an order that depends on content alone."""
    version, now = services.session.world.state()
    return Response(scene_turtle(scene_only(now)), media_type=TURTLE, headers={"ETag": etag(version)})


@router.get("/scene/diff", summary="What was changed in a scene", dependencies=[needs(Role.VIEWER)])
def get_scene_difference(
    services: ServicesDep,
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
    """Tells what makes the present scene of another one."""
    session, file, begin = services.session, _file(services, with_), int(cursor or 0)
    with _broken(409, with_):
        version, edits = services.stage.compare(session, file)
    page = edits[begin : begin + limit]
    return SceneDifference(
        name=with_,
        version=version,
        total=len(edits),
        edits=[edit.as_json() for edit in page],
        lines=list(describe(session.world.ontology, page)),
        next=str(begin + limit) if len(edits) > begin + limit else None,
    )


# ---------------------------------------------------------------- pieces


def _present(services: Services, response: Response) -> PresentScene:
    session = services.session
    version, now = session.world.state()
    name = _name(services)
    response.headers["ETag"] = etag(version)
    return PresentScene(
        name=name,
        version=version,
        changed=_is_changed(services, name),
        elements=len(scene_only(now).instances(ELEMENT)),
        learned=sum(map(is_learned, now.ids())),
        robots=_robots(now),
        goals=list(now.goals),
    )


def _name(services: Services) -> str:
    name, number = scene_of(services.session.world)
    saved = services.documents.get("scene", _SAVED_AS)
    return str(saved.data["name"]) if saved is not None and saved.data["version"] >= number else name


def _is_changed(services: Services, name: str) -> bool | None:
    try:
        return bool(services.stage.compare(services.session, services.scenes.find(name))[1])
    except (UsageError, FileError):  # it was uploaded, or removed since
        return None


def _robots(scene: Index) -> list[SceneRobot]:
    robots = (scene.element(id_) for id_ in scene.instances(ROBOT))
    return [SceneRobot(id=robot.id, label=robot.label, type=robot.type) for robot in robots]


def _entries(services: Services, names: list[str]) -> Iterator[SceneEntry]:
    for name in names:
        try:
            yield _entry(services.scenes.find(name))
        except (UsageError, FileError):  # it was removed meanwhile, or its plug-in is broken, which GET /plugins tells
            continue


def _entry(file: SceneFile) -> SceneEntry:
    return SceneEntry(name=file.name, source=_source(file), saved=file.written)


def _source(file: SceneFile) -> Any:
    return "saved" if file.saved else "installed"


def _file(services: Services, name: str) -> SceneFile:
    with found(_UNKNOWN), _broken(409, name):
        return services.scenes.find(name)


def _expected_file(services: Services, name: str, seen: str | None) -> int | None:
    """Returns the version of the saved scene that may be replaced; None where there is none."""
    try:
        with _broken(409, name):
            file = services.scenes.find(name)
    except UsageError:
        return expected_version(seen)
    if not file.saved:
        raise Problem(409, "SceneInstalled", f"'{name}' is a scene that came with a package: choose another name")
    require_version(seen, file.version)
    return file.version


@contextmanager
def _broken(status: int, name: str) -> Iterator[None]:
    """Says of a scene that cannot be read what is wrong with it, and where."""
    try:
        yield
    except FileError as error:
        text = f"{name} is broken, nothing was changed: {shown(error)}"
        raise Problem(status, "SceneBroken", text, line=error.line) from None


@contextmanager
def _unwritable() -> Iterator[None]:
    try:
        yield
    except FileError as error:
        raise Problem(507, "NotSaved", f"the scene is not saved: {shown(error)}") from None
