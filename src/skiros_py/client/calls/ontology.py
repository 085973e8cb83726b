"""The ontology: classes, relations and properties."""

from __future__ import annotations

from skiros_py.api.ontology import ClassDetails, ClassNode, PlacementOptions, PropertyPage, RelationInfoPage
from skiros_py.client.request import Call, path_of


def read_classes(root: str | None = None, *, depth: int | None = None) -> Call[ClassNode]:
    """Returns the tree of classes.

    Args:
        root: The root class.
        depth: How many levels below it.
    """
    query = {"root": root, "depth": depth}
    return Call("GET", "/ontology/classes", ClassNode, query=query)


def read_class(name: str) -> Call[ClassDetails]:
    """Returns a class."""
    path = path_of("ontology", "classes", name)
    return Call("GET", path, ClassDetails)


def list_ontology_relations(*, limit: int | None = None, cursor: str | None = None) -> Call[RelationInfoPage]:
    """Lists the relations by name."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/ontology/relations", RelationInfoPage, query=query)


def list_ontology_properties(*, limit: int | None = None, cursor: str | None = None) -> Call[PropertyPage]:
    """Lists the properties by name."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/ontology/properties", PropertyPage, query=query)


def read_placements(
    *,
    class_: str | None = None,
    element: str | None = None,
    relation: str | None = None,
    limit: int | None = None,
    cursor: str | None = None,
) -> Call[PlacementOptions]:
    """Returns where something may be placed.

    Args:
        class_: The class of a new thing.
        element: Or an existing element.
        relation: Only this placement relation.
        limit: Maximum number of places per relation.
        cursor: ``next`` of an earlier option, together with its relation.
    """
    query = {"class": class_, "element": element, "relation": relation, "limit": limit, "cursor": cursor}
    return Call("GET", "/ontology/placements", PlacementOptions, query=query)
