"""Routes: documents of all kinds, such as trees, sequences and goal templates."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Path, Query, Request, Response

from skiros_py.api.documents import DocumentContent, DocumentInfo, DocumentKinds, Documents
from skiros_py.server.access.roles import Act, Operator, Role, Viewer, ViewerOrMes
from skiros_py.server.problems import NEEDS_VERSION, Problem, SeenDep, etag, tagged, topic_router

router = topic_router("documents")

KindName = Annotated[str, Path(min_length=1, max_length=100, description="Kind of the document.", examples=["tree"])]
Id = Annotated[
    str, Path(alias="id", min_length=1, max_length=200, examples=["tidy up"], description="Id of the document.")
]
FormatQuery = Annotated[
    str | None, Query(alias="format", max_length=100, description="One of the formats of its kind.")
]
_WRITTEN = NEEDS_VERSION | tagged() | {201: {"model": DocumentInfo, "description": "It is new.", **tagged(201)[201]}}


def _check_orders(act: ViewerOrMes, kind: KindName) -> None:
    """Lets factory systems read only the documents that orders name.

    Raises:
        Problem: The caller is a factory system, and orders do not name such documents.
    """
    if act.caller.role is Role.MES and not act.station.documents.is_for_orders(kind):
        raise Problem(
            403, "RoleTooLow", f"a factory system reads the documents that orders name, not those of kind {kind}"
        )


_FOR_ORDERS = [Depends(_check_orders)]


@router.get("/documents")
def list_document_kinds(act: Viewer) -> DocumentKinds:
    """List the kinds of documents.

    Lists the kinds of documents, each with its text formats and the nodes that an editor offers.
    """
    return act.station.documents.kinds()


@router.get("/documents/{kind}", dependencies=_FOR_ORDERS)
def list_documents(act: ViewerOrMes, kind: KindName) -> Documents:
    """List documents.

    Lists the documents of a kind, by id.
    """
    return act.station.documents.all(kind)


@router.get("/documents/{kind}/{id}", dependencies=_FOR_ORDERS, responses=tagged())
def get_document(act: ViewerOrMes, kind: KindName, document: Id) -> DocumentInfo:
    """Read a document.

    Returns a document, with what would not work in the current world. Most kinds run as the module `{kind}:{id}`.
    """
    found = act.station.documents.get(kind, document)
    return act.tagged(found, found.revision)


@router.get("/documents/{kind}/{id}/revisions")
def list_document_revisions(act: Viewer, kind: KindName, document: Id) -> Documents:
    """List revisions.

    Lists the kept revisions of a document, oldest first; also of one that was removed.
    """
    return act.station.documents.revisions(kind, document)


@router.put("/documents/{kind}/{id}", responses=_WRITTEN)
def put_document(act: Operator, kind: KindName, document: Id, content: DocumentContent, seen: SeenDep) -> DocumentInfo:
    """Write a document.

    Writes a document; for an existing one, `If-Match` names the revision that was seen.

    It is checked first: each fault is answered with its place. Its next run is of this revision; active runs continue,
    and jobs that were ordered with a template do not change.
    """
    written, new = act.station.documents.put(kind, document, content.data, seen)
    return _written(act, written, new=new)


@router.delete("/documents/{kind}/{id}", status_code=204, responses=NEEDS_VERSION)
def remove_document(act: Operator, kind: KindName, document: Id, seen: SeenDep) -> None:
    """Remove a document.

    Removes a document; `If-Match` names the revision that was seen. Its active runs continue.
    """
    act.station.documents.remove(kind, document, seen)


@router.get(
    "/documents/{kind}/{id}/text",
    response_class=Response,
    responses={200: {"description": "The document.", "content": {"*/*": {}}, **tagged()[200]}},
)
def export_document(
    act: Viewer,
    kind: KindName,
    document: Id,
    format_: FormatQuery = None,
) -> Response:
    """Export a document.

    Returns a document as text in a format of its kind, by default the first one.
    """
    text, media_type, revision = act.station.documents.export(kind, document, format_)
    return Response(text, media_type=media_type, headers={"ETag": etag(revision)})


async def _text(request: Request) -> str:
    try:
        return (await request.body()).decode()
    except UnicodeDecodeError as error:
        raise Problem(422, "InvalidRequest", f"the text is not UTF-8: {error}") from None


@router.put(
    "/documents/{kind}/{id}/text",
    openapi_extra={"requestBody": {"required": True, "content": {"*/*": {"schema": {"type": "string"}}}}},
    responses=_WRITTEN,
)
def import_document(
    act: Operator,
    kind: KindName,
    document: Id,
    text: Annotated[str, Depends(_text)],
    seen: SeenDep,
) -> DocumentInfo:
    """Import a document.

    Writes a document from text; the content type names the format. A fault is answered with its place: line and column
    of the text, or the place in the document; then nothing is written.
    """
    media_type = act.request.headers.get("content-type", "").partition(";")[0].strip().lower()
    written, new = act.station.documents.import_text(kind, document, text, media_type, seen)
    return _written(act, written, new=new)


def _written(act: Act, document: DocumentInfo, *, new: bool) -> DocumentInfo:
    act.response.status_code = 201 if new else 200
    return act.tagged(document, document.revision)
