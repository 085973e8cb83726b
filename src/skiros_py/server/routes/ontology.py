"""Routes: ontology."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Annotated

from fastapi import APIRouter, Query

from skiros_py.api.ontology import (
    ClassDetails,
    ClassNode,
    PlacementOptions,
    PropertyPage,
    RelationPage,
)
from skiros_py.errors import UsageError
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.problems import found
from skiros_py.server.routes.parameters import Cursor, Limit, NamePath
from skiros_py.server.services import ServicesDep
from skiros_py.station.world.ontology import class_details, class_tree, property_info, relation_info
from skiros_py.station.world.placements import placement_options
from skiros_py.world.vocabulary import ELEMENT

__all__ = ["router"]

router = APIRouter(prefix="/ontology", tags=["ontology"])


@router.get("/classes", summary="Read the classes as a tree", dependencies=[needs(Role.VIEWER)])
def read_classes(
    services: ServicesDep,
    root: Annotated[
        str, Query(min_length=1, max_length=300, description="Where to begin.", examples=["sk:Manipulatable"])
    ] = ELEMENT,
    depth: Annotated[int, Query(ge=0, le=50, description="How many levels below it.")] = 50,
) -> ClassNode:
    """Tells what kinds of things there can be; a class with several parents stands below its primary one."""
    view = services.session.world.snapshot()
    with found():
        return class_tree(view, root, depth)


@router.get("/classes/{name}", summary="Read a class", dependencies=[needs(Role.VIEWER)])
def read_class(name: NamePath, services: ServicesDep) -> ClassDetails:
    """Tells what a class means, what its things may have, how many there are, and what takes them."""
    session = services.session
    with found():
        return class_details(session.world.snapshot(), name, session.catalogue)


@router.get("/relations", summary="List relations", dependencies=[needs(Role.VIEWER)])
def list_ontology_relations(services: ServicesDep, limit: Limit = 1000, cursor: Cursor = None) -> RelationPage:
    """Lists relations by name, with what may stand at their ends."""
    view = services.session.world.snapshot()
    names, more = _page(view.ontology.relations, limit, cursor)
    return RelationPage(items=[relation_info(view, view.ontology.relations[name]) for name in names], next=more)


@router.get("/properties", summary="List properties", dependencies=[needs(Role.VIEWER)])
def list_ontology_properties(services: ServicesDep, limit: Limit = 1000, cursor: Cursor = None) -> PropertyPage:
    """Lists properties by name, with data type and unit."""
    ontology = services.session.world.ontology
    names, more = _page(ontology.properties, limit, cursor)
    return PropertyPage(items=[property_info(ontology.properties[name]) for name in names], next=more)


def _page(names: Iterable[str], limit: int, cursor: str | None) -> tuple[list[str], str | None]:
    found = list(islice((name for name in sorted(names) if name > (cursor or "")), limit + 1))
    return found[:limit], found[limit - 1] if len(found) > limit else None


@router.get("/placements", summary="Ask what may be put where", dependencies=[needs(Role.VIEWER)])
def read_placements(
    services: ServicesDep,
    class_: Annotated[
        str | None, Query(alias="class", min_length=1, max_length=300, description="A new thing of this class.")
    ] = None,
    element: Annotated[str | None, Query(min_length=1, max_length=300, description="This element.")] = None,
    relation: Annotated[str | None, Query(min_length=1, max_length=300, description="Only by this relation.")] = None,
    limit: Annotated[int, Query(ge=1, le=200, description="How many places of each relation at most.")] = 50,
    cursor: Cursor = None,
) -> PlacementOptions:
    """Tells by which relations a thing may be placed, and of each place there is whether it would take it now.

    Either `class` or `element` says what is to be put somewhere. Each place is tried in a state that nobody sees: what
    ontology and reasoners would refuse is refused here in the same words.
    """
    if (class_ is None) == (element is None):
        raise UsageError("say what is to be put somewhere: either class=kitting:Starter or element=starter_1")
    if cursor is not None and relation is None:
        raise UsageError("a cursor goes on with the places of one relation: give relation=sk:in, too")
    view = services.session.world.snapshot()
    what = view.element(element).type if element is not None else class_
    assert what is not None
    view.ontology.ancestors(what)
    return placement_options(view, what, element, limit, relation, cursor or "")
