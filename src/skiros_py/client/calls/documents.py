"""Documents that robots run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skiros_py.api.modules import DocumentInfo, DocumentKinds, Documents
from skiros_py.client.request import Call, if_match, nothing, path_of


def list_document_kinds() -> Call[DocumentKinds]:
    """Lists the kinds of documents, each with the nodes that an editor offers."""
    return Call("GET", "/documents", DocumentKinds)


def list_documents(kind: str) -> Call[Documents]:
    """Lists the documents of a kind."""
    return Call("GET", path_of("documents", kind), Documents)


def get_document(kind: str, id_: str) -> Call[DocumentInfo]:
    """Returns a document."""
    return Call("GET", path_of("documents", kind, id_), DocumentInfo)


def list_document_revisions(kind: str, id_: str) -> Call[Documents]:
    """Lists all revisions of a document."""
    return Call("GET", path_of("documents", kind, id_, "revisions"), Documents)


def put_document(kind: str, id_: str, data: Mapping[str, Any], *, seen: int | None = None) -> Call[DocumentInfo]:
    """Writes a document; the next run uses this revision.

    Args:
        kind: Its kind.
        id_: Its id.
        data: Its content.
        seen: Revision of the existing document, if any.
    """
    headers = if_match(seen)
    return Call(
        "PUT", path_of("documents", kind, id_), DocumentInfo, json={"data": data}, headers=headers, repeatable=False
    )


def remove_document(kind: str, id_: str, *, seen: int) -> Call[None]:
    """Removes a document."""
    return Call("DELETE", path_of("documents", kind, id_), nothing, headers=if_match(seen), repeatable=False)
