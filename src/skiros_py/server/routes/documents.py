"""Routes: documents of all kinds, such as trees, sequences and goal templates."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path, Query, Request, Response

from skiros_py.api.documents import DocumentContent, DocumentInfo, DocumentKinds, Documents
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import NEEDS_VERSION, Problem, SeenDep, etag, tagged
from skiros_py.server.services import StationDep

router = APIRouter(tags=["documents"])

KindName = Annotated[str, Path(min_length=1, max_length=100, description="Kind of the document.", examples=["tree"])]
Id = Annotated[
    str, Path(alias="id", min_length=1, max_length=200, examples=["tidy up"], description="Id of the document.")
]
FormatQuery = Annotated[
    str | None, Query(alias="format", max_length=100, description="One of the formats of its kind.")
]
_WRITTEN = NEEDS_VERSION | tagged() | {201: {"model": DocumentInfo, "description": "It is new.", **tagged(201)[201]}}


def _check_orders(kind: KindName, station: StationDep, caller: CallerDep) -> None:
    """Lets factory systems read only the documents that orders name.

    Raises:
        Problem: The caller is a factory system, and orders do not name such documents.
    """
    if caller.role is Role.MES and not station.documents.is_for_orders(kind):
        raise Problem(
            403, "RoleTooLow", f"a factory system reads the documents that orders name, not those of kind {kind}"
        )


_READ = [needs(Role.VIEWER, mes=True), Depends(_check_orders)]


@router.get("/documents", dependencies=[needs(Role.VIEWER)])
def list_document_kinds(station: StationDep) -> DocumentKinds:
    """List the kinds of documents.

    Lists the kinds of documents, each with its text formats and the nodes that an editor offers.
    """
    return station.documents.kinds()


@router.get("/documents/{kind}", dependencies=_READ)
def list_documents(kind: KindName, station: StationDep) -> Documents:
    """List documents.

    Lists the documents of a kind, by id.
    """
    return station.documents.all(kind)


@router.get("/documents/{kind}/{id}", dependencies=_READ, responses=tagged())
def get_document(kind: KindName, document: Id, station: StationDep, response: Response) -> DocumentInfo:
    """Read a document.

    Returns a document, with what would not work in the present world. Most kinds run as the module `{kind}:{id}`.
    """
    return _tagged(station.documents.get(kind, document), response)


@router.get("/documents/{kind}/{id}/revisions", dependencies=[needs(Role.VIEWER)])
def list_document_revisions(kind: KindName, document: Id, station: StationDep) -> Documents:
    """List revisions.

    Lists the kept revisions of a document, oldest first; also of one that was removed.
    """
    return station.documents.revisions(kind, document)


@router.put("/documents/{kind}/{id}", dependencies=[needs(Role.OPERATOR)], responses=_WRITTEN)
def put_document(
    kind: KindName, document: Id, content: DocumentContent, station: StationDep, seen: SeenDep, response: Response
) -> DocumentInfo:
    """Write a document.

    Writes a document; for an existing one, `If-Match` names the revision that was seen.

    It is checked first: each fault is answered with its place. Its next run is of this revision; active runs continue,
    and jobs that were ordered with a template do not change.
    """
    return _written(station.documents.put(kind, document, content.data, seen), response)


@router.delete("/documents/{kind}/{id}", status_code=204, dependencies=[needs(Role.OPERATOR)], responses=NEEDS_VERSION)
def remove_document(kind: KindName, document: Id, station: StationDep, seen: SeenDep) -> None:
    """Remove a document.

    Removes a document; `If-Match` names the revision that was seen. Its active runs continue.
    """
    station.documents.remove(kind, document, seen)


@router.get(
    "/documents/{kind}/{id}/text",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses={200: {"description": "The document.", "content": {"*/*": {}}, **tagged()[200]}},
)
def export_document(
    kind: KindName,
    document: Id,
    station: StationDep,
    format_: FormatQuery = None,
) -> Response:
    """Export a document.

    Returns a document as text in a format of its kind, by default the first one.
    """
    text, media_type, revision = station.documents.export(kind, document, format_)
    return Response(text, media_type=media_type, headers={"ETag": etag(revision)})


async def _text(request: Request) -> str:
    try:
        return (await request.body()).decode()
    except UnicodeDecodeError as error:
        raise Problem(422, "InvalidRequest", f"the text is not UTF-8: {error}") from None


@router.put(
    "/documents/{kind}/{id}/text",
    dependencies=[needs(Role.OPERATOR)],
    openapi_extra={"requestBody": {"required": True, "content": {"*/*": {"schema": {"type": "string"}}}}},
    responses=_WRITTEN,
)
def import_document(
    kind: KindName,
    document: Id,
    text: Annotated[str, Depends(_text)],
    request: Request,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> DocumentInfo:
    """Import a document.

    Writes a document from text; the content type names the format. A fault is answered with its place: line and column
    of the text, or the place in the document; then nothing is written.
    """
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    return _written(station.documents.import_text(kind, document, text, media_type, seen), response)


def _written(written: tuple[DocumentInfo, bool], response: Response) -> DocumentInfo:
    document, new = written
    response.status_code = 201 if new else 200
    return _tagged(document, response)


def _tagged(document: DocumentInfo, response: Response) -> DocumentInfo:
    response.headers["ETag"] = etag(document.revision)
    return document
