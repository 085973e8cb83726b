"""The ontology: what may be."""

from __future__ import annotations

from skiros_py.api.ontology import ClassDetails, ClassNode, PlacementOptions, PropertyPage, RelationPage
from skiros_py.client.call import Call, path_of


def read_classes(root: str | None = None, *, depth: int | None = None) -> Call[ClassNode]:
    """Returns what kinds of things there can be, as a tree.

    Args:
        root: The class to begin with.
        depth: How many levels below it.
    """
    query = {"root": root, "depth": depth}
    return Call("GET", "/ontology/classes", ClassNode, query=query)


def read_class(name: str) -> Call[ClassDetails]:
    """Describes a class."""
    path = path_of("ontology", "classes", name)
    return Call("GET", path, ClassDetails)


def list_ontology_relations(*, limit: int | None = None, cursor: str | None = None) -> Call[RelationPage]:
    """Lists the relations that there may be, by name."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/ontology/relations", RelationPage, query=query)


def list_ontology_properties(*, limit: int | None = None, cursor: str | None = None) -> Call[PropertyPage]:
    """Lists the properties that elements may have, by name."""
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
    """Returns where something may be put.

    Args:
        class_: A new thing of this class.
        element: Or this element.
        relation: Only by this relation.
        limit: How many places of each relation at most.
        cursor: ``next`` of an option as told before, together with its relation.
    """
    query = {"class": class_, "element": element, "relation": relation, "limit": limit, "cursor": cursor}
    return Call("GET", "/ontology/placements", PlacementOptions, query=query)
