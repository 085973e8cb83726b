"""Routes: ontology."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Depends, Header, Query
from werkzeug.datastructures import LanguageAccept
from werkzeug.http import parse_accept_header

from skiros_py.api import ontology as api
from skiros_py.api.world import EVERYTHING
from skiros_py.server.access.roles import Anybody, Viewer
from skiros_py.server.problems import topic_router
from skiros_py.server.routes.world import Cursor, Limit, NamePath


def _negotiated(  # in the thread pool: the station may be opening
    act: Anybody,
    accept_language: Annotated[
        str,
        Header(max_length=1000, description="Languages of labels and comments, best first.", examples=["de, en;q=0.5"]),
    ] = "",
) -> str:
    """Returns the best of the languages that the ontology has, else English, and puts it into the headers."""
    given = parse_accept_header(accept_language, LanguageAccept)
    # Else an exact tag of low quality would come before a regional one of high quality: "de;q=0.1, en-GB".
    accepted = LanguageAccept([*given, *((tag.partition("-")[0], quality) for tag, quality in given if quality > 0)])
    language = accepted.best_match(act.station.ontology.languages, "en")
    act.response.headers.update({"Content-Language": language, "Vary": "Accept-Language"})
    return language


Language = Annotated[str, Depends(_negotiated)]
"""For routes with labels or comments: the language to answer in."""

_TOLD: dict[int | str, dict[str, Any]] = {
    200: {
        "headers": {
            "Content-Language": {"description": "Language of labels and comments.", "schema": {"type": "string"}}
        }
    }
}

router = topic_router("ontology", "/ontology", _TOLD)


@router.get("/classes")
def read_classes(
    act: Viewer,
    language: Language,
    root: Annotated[str, Query(min_length=1, max_length=300, examples=["sk:Manipulatable"])] = EVERYTHING,
    depth: Annotated[int, Query(ge=0, le=50)] = 50,
) -> api.ClassNode:
    """Read the classes as a tree.

    Returns the classes of elements; a class with several parents is listed below its primary one.

    Parameters:
        root: The class at the root.
        depth: Number of levels below it.
    """
    return act.station.ontology.classes(root, depth, language=language)


@router.get("/classes/{name}")
def read_class(act: Viewer, language: Language, name: NamePath) -> api.ClassDetails:
    """Read a class.

    Returns the meaning of a class, the properties and relations of its elements, and how many there are.
    """
    return act.station.ontology.class_(name, language=language)


@router.get("/relations")
def list_ontology_relations(
    act: Viewer, language: Language, limit: Limit = 1000, cursor: Cursor = None
) -> api.RelationInfoPage:
    """List relations.

    Lists relations by name, with the classes permitted at their ends.
    """
    return act.station.ontology.relations(limit, cursor or "", language=language)


@router.get("/properties")
def list_ontology_properties(
    act: Viewer, language: Language, limit: Limit = 1000, cursor: Cursor = None
) -> api.PropertyPage:
    """List properties.

    Lists properties by name, with data type and unit.
    """
    return act.station.ontology.properties(limit, cursor or "", language=language)


@router.get("/placements")
def read_placements(
    act: Viewer,
    language: Language,
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
    return act.station.ontology.placements(class_, element, relation, limit, cursor, language=language)
