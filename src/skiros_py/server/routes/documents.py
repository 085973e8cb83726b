"""Routes: documents that robots run, of whatever kind plug-ins bring."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Path, Response

from skiros_py.api.documents import (
    DocumentContent,
    DocumentInfo,
    DocumentKindInfo,
    DocumentKinds,
    Documents,
    PaletteNode,
)
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.etags import NEEDS_VERSION, VersionDep, etag, require_version, tagged
from skiros_py.server.job_faults import job_faults
from skiros_py.server.problems import found
from skiros_py.server.services import ServicesDep
from skiros_py.station.documents import Document

__all__ = ["router"]

router = APIRouter(tags=["documents"])

KindName = Annotated[str, Path(min_length=1, max_length=100, description="Kind of the document.", examples=["tree"])]
Id = Annotated[str, Path(min_length=1, max_length=200, description="Id of the document.", examples=["tidy up"])]


@router.get("/documents", summary="List the kinds of documents", dependencies=[needs(Role.VIEWER)])
def list_document_kinds(services: ServicesDep) -> DocumentKinds:
    """Lists the kinds of documents that plug-ins bring, each with the nodes that an editor offers."""
    runnable = services.runnable
    return DocumentKinds(
        kinds=tuple(
            DocumentKindInfo(
                kind=kind,
                formats=runnable.formats(kind),
                palette=tuple(PaletteNode(**asdict(entry)) for entry in runnable.palette(kind)),
            )
            for kind in runnable.kinds
        )
    )


@router.get("/documents/{kind}", summary="List documents", dependencies=[needs(Role.VIEWER)])
def list_documents(kind: KindName, services: ServicesDep) -> Documents:
    """Lists the documents of a kind, by id."""
    with found():
        return Documents(documents=tuple(map(_info, services.runnable.all(kind))))


@router.get(
    "/documents/{kind}/{id}", summary="Look at a document", dependencies=[needs(Role.VIEWER)], responses=tagged()
)
def get_document(kind: KindName, id: Id, services: ServicesDep, response: Response) -> DocumentInfo:  # noqa: A002
    """Shows a document as it is now; it runs as the module `{kind}:{id}`."""
    with found():
        return _shown(services.runnable.find(kind, id), response)


@router.get("/documents/{kind}/{id}/revisions", summary="List revisions", dependencies=[needs(Role.VIEWER)])
def list_document_revisions(kind: KindName, id: Id, services: ServicesDep) -> Documents:  # noqa: A002
    """Lists all revisions of a document, the oldest first; also of one that was removed."""
    with found():
        return Documents(documents=tuple(map(_info, services.runnable.revisions(kind, id))))


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
    services: ServicesDep,
    seen: VersionDep,
    response: Response,
) -> DocumentInfo:
    """Writes a document; for one that is there already, `If-Match` names the revision that was seen.

    It is checked first: a fault is answered with its place. Its next run is of this revision; what runs goes on.
    """
    with found():
        known = services.runnable.get(kind, id)
    if known is not None:
        require_version(seen, known.version)
    with job_faults():
        expects = 0 if known is None else known.version
        written = services.runnable.write(kind, id, content.data, expects=expects)
    response.status_code = 201 if known is None else 200
    return _shown(written, response)


@router.delete(
    "/documents/{kind}/{id}",
    summary="Remove a document",
    status_code=204,
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION,
)
def remove_document(kind: KindName, id: Id, services: ServicesDep, seen: VersionDep) -> None:  # noqa: A002
    """Removes a document; `If-Match` names the revision that was seen. What runs of it goes on."""
    with found():
        known = services.runnable.find(kind, id)
    require_version(seen, known.version)
    with job_faults():
        services.runnable.remove(kind, id, expects=known.version)


def _shown(document: Document, response: Response) -> DocumentInfo:
    response.headers["ETag"] = etag(document.version)
    return _info(document)


def _info(document: Document) -> DocumentInfo:
    kind, name = document.kind, document.name
    return DocumentInfo(kind=kind, id=name, revision=document.version, module=f"{kind}:{name}", data=document.data)
