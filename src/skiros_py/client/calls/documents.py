"""Documents of all kinds, such as trees, sequences and goal templates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import httpx2

from skiros_py.api.documents import DocumentInfo, DocumentKinds, Documents
from skiros_py.client.request import Call, if_match, nothing, path_of


def list_document_kinds() -> Call[DocumentKinds]:
    """Lists the kinds of documents, each with its formats and the nodes that an editor offers."""
    return Call("GET", "/documents", DocumentKinds)


def list_documents(kind: str) -> Call[Documents]:
    """Lists the documents of a kind."""
    return Call("GET", path_of("documents", kind), Documents)


def get_document(kind: str, id_: str) -> Call[DocumentInfo]:
    """Returns a document, with what would not work in the present world."""
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
    path, headers = path_of("documents", kind, id_), if_match(seen)
    return Call("PUT", path, DocumentInfo, json={"data": data}, headers=headers, repeatable=False)


def remove_document(kind: str, id_: str, *, seen: int) -> Call[None]:
    """Removes a document."""
    return Call("DELETE", path_of("documents", kind, id_), nothing, headers=if_match(seen), repeatable=False)


def export_document(kind: str, id_: str, format_: str | None = None) -> Call[str]:
    """Returns a document as text.

    Args:
        kind: Its kind.
        id_: Its id.
        format_: One of the formats of its kind; None for the first one.
    """
    return Call("GET", path_of("documents", kind, id_, "text"), _text, query={"format": format_})


def import_document(
    kind: str, id_: str, text: str, media_type: str = "application/json", *, seen: int | None = None
) -> Call[DocumentInfo]:
    """Writes a document from text.

    Args:
        kind: Its kind.
        id_: Its id.
        text: The text.
        media_type: Media type of its format, one of those of its kind.
        seen: Revision of the existing document, if any.
    """
    headers = {"Content-Type": media_type, **if_match(seen)}
    path, content = path_of("documents", kind, id_, "text"), text.encode()
    return Call("PUT", path, DocumentInfo, content=content, headers=headers, repeatable=False)


def _text(response: httpx2.Response) -> str:
    return response.text
