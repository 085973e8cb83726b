"""Routes: ontology."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from skiros_py.api.ontology import (
    ClassDetails,
    ClassNode,
    PlacementOptions,
    PropertyPage,
    RelationPage,
)
from skiros_py.api.world import EVERYTHING
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.routes.world import Cursor, Limit, NamePath
from skiros_py.server.services import StationDep

router = APIRouter(prefix="/ontology", tags=["ontology"])


@router.get("/classes", dependencies=[needs(Role.VIEWER)])
def read_classes(
    station: StationDep,
    root: Annotated[
        str, Query(min_length=1, max_length=300, description="Where to begin.", examples=["sk:Manipulatable"])
    ] = EVERYTHING,
    depth: Annotated[int, Query(ge=0, le=50, description="How many levels below it.")] = 50,
) -> ClassNode:
    """Read the classes as a tree.

    Returns what kinds of things there can be; a class with several parents stands below its primary one.
    """
    return station.ontology.classes(root, depth)


@router.get("/classes/{name}", dependencies=[needs(Role.VIEWER)])
def read_class(name: NamePath, station: StationDep) -> ClassDetails:
    """Read a class.

    Returns what a class means, what its things may have, how many there are, and what takes them.
    """
    return station.ontology.class_(name)


@router.get("/relations", dependencies=[needs(Role.VIEWER)])
def list_ontology_relations(station: StationDep, limit: Limit = 1000, cursor: Cursor = None) -> RelationPage:
    """List relations.

    Lists relations by name, with what may stand at their ends.
    """
    return station.ontology.relations(limit, cursor or "")


@router.get("/properties", dependencies=[needs(Role.VIEWER)])
def list_ontology_properties(station: StationDep, limit: Limit = 1000, cursor: Cursor = None) -> PropertyPage:
    """List properties.

    Lists properties by name, with data type and unit.
    """
    return station.ontology.properties(limit, cursor or "")


@router.get("/placements", dependencies=[needs(Role.VIEWER)])
def read_placements(
    station: StationDep,
    class_: Annotated[
        str | None, Query(alias="class", min_length=1, max_length=300, description="A new thing of this class.")
    ] = None,
    element: Annotated[str | None, Query(min_length=1, max_length=300, description="This element.")] = None,
    relation: Annotated[str | None, Query(min_length=1, max_length=300, description="Only by this relation.")] = None,
    limit: Annotated[int, Query(ge=1, le=200, description="How many places of each relation at most.")] = 50,
    cursor: Cursor = None,
) -> PlacementOptions:
    """Ask what may be put where.

    Tells by which relations a thing may be placed, and of each place there is whether it would take it now.

    Either `class` or `element` says what is to be put somewhere. Each place is tried in a private state: what
    ontology and reasoners would refuse is refused here in the same words.
    """
    return station.ontology.placements(class_, element, relation, limit, cursor)
