"""Routes: documents that robots run, of whatever kind plug-ins bring."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response

from skiros_py.api.documents import (
    DocumentContent,
    DocumentInfo,
    DocumentKinds,
    Documents,
)
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.etags import NEEDS_VERSION, SeenDep, etag, tagged
from skiros_py.server.services import StationDep

router = APIRouter(tags=["documents"])

KindName = Annotated[str, Path(min_length=1, max_length=100, description="Kind of the document.", examples=["tree"])]
Id = Annotated[str, Path(min_length=1, max_length=200, description="Id of the document.", examples=["tidy up"])]


@router.get("/documents", summary="List the kinds of documents", dependencies=[needs(Role.VIEWER)])
def list_document_kinds(station: StationDep) -> DocumentKinds:
    """Lists the kinds of documents that plug-ins bring, each with the nodes that an editor offers."""
    return station.behaviours.kinds()


@router.get("/documents/{kind}", summary="List documents", dependencies=[needs(Role.VIEWER)])
def list_documents(kind: KindName, station: StationDep) -> Documents:
    """Lists the documents of a kind, by id."""
    return station.behaviours.all(kind)


@router.get(
    "/documents/{kind}/{id}", summary="Look at a document", dependencies=[needs(Role.VIEWER)], responses=tagged()
)
def get_document(kind: KindName, id: Id, station: StationDep, response: Response) -> DocumentInfo:  # noqa: A002
    """Shows a document as it is now; it runs as the module `{kind}:{id}`."""
    return _tagged(station.behaviours.get(kind, id), response)


@router.get("/documents/{kind}/{id}/revisions", summary="List revisions", dependencies=[needs(Role.VIEWER)])
def list_document_revisions(kind: KindName, id: Id, station: StationDep) -> Documents:  # noqa: A002
    """Lists all revisions of a document, the oldest first; also of one that was removed."""
    return station.behaviours.revisions(kind, id)


@router.put(
    "/documents/{kind}/{id}",
    summary="Write a document",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION
    | tagged()
    | {201: {"model": DocumentInfo, "description": "It is new.", **tagged(201)[201]}},
)
def put_document(
    kind: KindName,
    id: Id,  # noqa: A002
    content: DocumentContent,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> DocumentInfo:
    """Writes a document; for one that is there already, `If-Match` names the revision that was seen.

    It is checked first: a fault is answered with its place. Its next run is of this revision; what runs goes on.
    """
    document, new = station.behaviours.put(kind, id, content.data, seen)
    response.status_code = 201 if new else 200
    return _tagged(document, response)


@router.delete(
    "/documents/{kind}/{id}",
    summary="Remove a document",
    status_code=204,
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION,
)
def remove_document(kind: KindName, id: Id, station: StationDep, seen: SeenDep) -> None:  # noqa: A002
    """Removes a document; `If-Match` names the revision that was seen. What runs of it goes on."""
    station.behaviours.remove(kind, id, seen)


def _tagged(document: DocumentInfo, response: Response) -> DocumentInfo:
    response.headers["ETag"] = etag(document.revision)
    return document
