"""Routes: ontology."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query

from skiros_py.api import ontology as api
from skiros_py.api.world import EVERYTHING
from skiros_py.server.access.roles import Viewer
from skiros_py.server.problems import topic_router
from skiros_py.server.routes.world import Cursor, Limit, NamePath

router = topic_router("ontology", "/ontology")


@router.get("/classes")
def read_classes(
    act: Viewer,
    root: Annotated[str, Query(min_length=1, max_length=300, examples=["sk:Manipulatable"])] = EVERYTHING,
    depth: Annotated[int, Query(ge=0, le=50)] = 50,
) -> api.ClassNode:
    """Read the classes as a tree.

    Returns the classes of elements; a class with several parents is listed below its primary one.

    Parameters:
        root: The class at the root.
        depth: Number of levels below it.
    """
    return act.station.ontology.classes(root, depth)


@router.get("/classes/{name}")
def read_class(act: Viewer, name: NamePath) -> api.ClassDetails:
    """Read a class.

    Returns the meaning of a class, the properties and relations of its elements, and how many there are.
    """
    return act.station.ontology.class_(name)


@router.get("/relations")
def list_ontology_relations(act: Viewer, limit: Limit = 1000, cursor: Cursor = None) -> api.RelationInfoPage:
    """List relations.

    Lists relations by name, with the classes permitted at their ends.
    """
    return act.station.ontology.relations(limit, cursor or "")


@router.get("/properties")
def list_ontology_properties(act: Viewer, limit: Limit = 1000, cursor: Cursor = None) -> api.PropertyPage:
    """List properties.

    Lists properties by name, with data type and unit.
    """
    return act.station.ontology.properties(limit, cursor or "")


@router.get("/placements")
def read_placements(
    act: Viewer,
    class_: Annotated[str | None, Query(alias="class", min_length=1, max_length=300)] = None,
    element: Annotated[str | None, Query(min_length=1, max_length=300)] = None,
    relation: Annotated[str | None, Query(min_length=1, max_length=300)] = None,
    limit: Annotated[int, Query(ge=1, le=200)] = 50,
    cursor: Cursor = None,
) -> api.PlacementOptions:
    """List possible placements.

    Returns the relations by which an element may be placed, and whether each existing place accepts it now.

    Give either `class` or `element`. Each place is tried on a copy of the world: what the ontology or a reasoner would
    refuse is reported with the same message.

    Parameters:
        class: Class of a new element.
        element: Id of an existing element.
        relation: Only this relation.
        limit: Maximum number of places per relation.
    """
    return act.station.ontology.placements(class_, element, relation, limit, cursor)
