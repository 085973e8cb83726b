"""Elements of the world."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api.world import ChangePage, ElementDetails, ElementPage, ElementPatch, NewElement, RelationPage, Written
from skiros_py.client.request import Call, if_match, path_of


def list_elements(
    *,
    class_: str | None = None,
    label: str | None = None,
    text: str | None = None,
    place: str | None = None,
    abstract: bool | None = None,
    limit: int | None = None,
    cursor: str | None = None,
) -> Call[ElementPage]:
    """Lists elements in the order of their ids.

    Args:
        class_: Only of this class or a subclass.
        label: Only with exactly this label.
        text: Only with this text in id, label or class.
        place: Only those placed directly here.
        abstract: True for elements described by the ontology or learned.
        limit: How many at most.
        cursor: ``next`` of the previous page.
    """
    query = {"class": class_, "label": label, "text": text, "place": place}
    paging = {"abstract": abstract, "limit": limit, "cursor": cursor}
    return Call("GET", "/elements", ElementPage, query={**query, **paging})


def read_element(element: str, *, computed: Sequence[str] = ()) -> Call[ElementDetails]:
    """Returns an element.

    Args:
        element: Its id.
        computed: Computed relations to evaluate; "all" for all.
    """
    return Call("GET", path_of("elements", element), ElementDetails, query={"computed": list(computed) or None})


def list_relations(
    element: str, *, relation: str | None = None, limit: int | None = None, cursor: str | None = None
) -> Call[RelationPage]:
    """Lists the relations of an element, in both directions.

    Args:
        element: Its id.
        relation: Only this relation or its sub-relations; may be a computed one.
        limit: How many at most.
        cursor: ``next`` of the previous page.
    """
    query = {"relation": relation, "limit": limit, "cursor": cursor}
    return Call("GET", path_of("elements", element, "relations"), RelationPage, query=query)


def read_element_history(
    element: str, *, newest_first: bool = True, limit: int | None = None, cursor: str | None = None
) -> Call[ChangePage]:
    """Returns the changes that affected an element, which may have been removed.

    Args:
        element: Its id.
        newest_first: Whether to go back in time.
        limit: How many at most.
        cursor: ``next`` of the previous page.
    """
    query = {"newest_first": newest_first, "limit": limit, "cursor": cursor}
    return Call("GET", path_of("elements", element, "history"), ChangePage, query=query)


def add_element(new: NewElement) -> Call[ElementDetails]:
    """Adds an element with its values, its place and its relations."""
    body = new.model_dump(mode="json", by_alias=True, exclude_unset=True)
    return Call("POST", "/elements", ElementDetails, json=body, repeatable=False)


def change_element(element: str, patch: ElementPatch, *, version: int | None = None) -> Call[ElementDetails]:
    """Changes label, values and place of an element.

    Args:
        element: Its id.
        patch: The changes.
        version: The version that was seen; None for whatever it is now.
    """
    body = patch.model_dump(mode="json", by_alias=True, exclude_unset=True)
    return Call("PATCH", path_of("elements", element), ElementDetails, json=body, headers=if_match(version, "*"))


def remove_element(element: str, *, version: int | None = None, reason: str | None = None) -> Call[Written]:
    """Removes an element with its parts.

    Args:
        element: Its id.
        version: The version that was seen; None for whatever it is now.
        reason: Why.
    """
    return Call(
        "DELETE",
        path_of("elements", element),
        Written,
        query={"reason": reason},
        headers=if_match(version, "*"),
        repeatable=False,
    )


def state_relation(
    element: str, relation: str, other: str, *, version: int | None = None, reason: str | None = None
) -> Call[Written]:
    """States that the first element has the relation to the second; a placement moves its element.

    Args:
        element: The subject.
        relation: The relation.
        other: The object.
        version: The version of the subject that was seen; None for whatever it is now.
        reason: Why.
    """
    path = _related(element, relation, other)
    return Call("PUT", path, Written, query={"reason": reason}, headers=if_match(version, "*"))


def take_back_relation(
    element: str, relation: str, other: str, *, version: int | None = None, reason: str | None = None
) -> Call[Written]:
    """Removes a stated relation; arguments as for :func:`state_relation`."""
    path = _related(element, relation, other)
    return Call("DELETE", path, Written, query={"reason": reason}, headers=if_match(version, "*"), repeatable=False)


def _related(element: str, relation: str, other: str) -> str:
    return path_of("elements", element, "relations", relation, other)
