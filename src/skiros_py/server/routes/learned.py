"""Routes: learned."""

from __future__ import annotations

from fastapi import APIRouter, Response

from skiros_py.api.learned import Learned, LearnedPage
from skiros_py.api.world import Written
from skiros_py.errors import UnknownName
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, VersionDep, expected_version, require_version
from skiros_py.server.problems import found
from skiros_py.server.routes.parameters import Cursor, ElementPath, Limit, WhyQuery
from skiros_py.server.services import ServicesDep
from skiros_py.server.world.changes import written
from skiros_py.server.world.editing import writing
from skiros_py.station.world.values import told
from skiros_py.world.element import is_learned
from skiros_py.world.index import Index
from skiros_py.world.scene.learned import learned_turtle
from skiros_py.world.vocabulary import APPLIES_TO, ELEMENT

__all__ = ["router"]

router = APIRouter(tags=["learned"])


@router.get("/learned", summary="List what robots were taught", dependencies=[needs(Role.VIEWER)])
def list_learned(services: ServicesDep, limit: Limit = 100, cursor: Cursor = None) -> LearnedPage:
    """Lists what robots were taught and keep beyond this scene, in the order of ids."""
    view = services.session.world.snapshot()
    names = [name for name in _learned(view) if name > (cursor or "")]
    shown = names[:limit]
    return LearnedPage(items=[_told(view, name) for name in shown], next=shown[-1] if len(names) > limit else None)


def _learned(view: Index) -> list[str]:
    return [name for name in view.abstracts(ELEMENT) if is_learned(name)]


def _told(view: Index, name: str) -> Learned:
    element = view.element(name)
    about = element.properties.get(APPLIES_TO)
    return Learned(
        id=name,
        class_=element.type,
        label=element.label,
        about=None if about is None else str(about),
        properties={key: told(value) for key, value in sorted(element.properties.items())},
        version=view.stamp(name).change,
    )


@router.delete(
    "/learned/{element}", summary="Forget something", dependencies=[needs(Role.ENGINEER)], responses=NEEDS_VERSION
)
def forget_learned(
    element: ElementPath, services: ServicesDep, caller: CallerDep, seen: VersionDep, reason: WhyQuery = ""
) -> Written:
    """Forgets something with its pieces; an undo brings it back."""
    world = services.session.world
    view = world.snapshot()
    with found():
        if not (is_learned(element) and view.has(element)):
            raise UnknownName("learned concept", element, _learned(view))
    require_version(seen, view.stamp(element).change)
    version = expected_version(seen)
    expects = {} if version is None else {element: version}
    with writing(world, caller, reason or f"forgets {element}", expects) as tx:
        tx.remove(element)
    return written(world, tx)


@router.get(
    "/learned.ttl",
    summary="Read what robots were taught as Turtle",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses={200: {"content": {"text/turtle": {"schema": {"type": "string"}}}}},
)
def export_learned(services: ServicesDep) -> Response:
    """Writes everything that was learned as the text of a file.

    Another robot knows it from the start when the file lies in its new data directory as learned.ttl.
    """
    text = learned_turtle(services.session.world.snapshot())
    return Response(text, media_type="text/turtle; charset=utf-8")
