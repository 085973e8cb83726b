"""Use cases: documents that robots run, of the kinds provided by plug-ins."""

from __future__ import annotations

import logging
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from skiros_py.api.alarms import AlarmKind
from skiros_py.api.documents import DocumentInfo, DocumentKindInfo, DocumentKinds, Documents, PaletteNode
from skiros_py.errors import SkirosError
from skiros_py.station.documents import Document
from skiros_py.station.requests import ANY_VERSION, Seen, addressed, require_seen
from skiros_py.station.runnable import RunnableDocuments
from skiros_py.station.session import Session

if TYPE_CHECKING:
    from skiros_py.station.station import Station

_log = logging.getLogger(__name__)


class DocumentService:
    """Stores runnable documents with their revisions.

    Args:
        station: The station.
    """

    def __init__(self, station: Station) -> None:
        self._station = station
        self._runnable: RunnableDocuments

    def open(self, session: Session) -> None:
        """Offers the documents as modules of a session, as soon as the store is open."""
        if hasattr(self._station, "documents"):
            self._runnable = RunnableDocuments(self._station.documents, session)
            for module, reason in self._runnable.set_aside.items():
                self._station.alarm_book.raise_(AlarmKind.MODULE, f"{module} cannot run: {reason}", module)

    def kinds(self) -> DocumentKinds:
        """Lists the kinds of documents, each with the nodes that an editor offers."""
        runnable = self._runnable
        return DocumentKinds(
            kinds=tuple(
                DocumentKindInfo(
                    kind=kind,
                    formats=runnable.formats(kind),
                    palette=self._palette(kind),
                )
                for kind in runnable.kinds
            )
        )

    def _palette(self, kind: str) -> tuple[PaletteNode, ...]:
        try:
            return tuple(PaletteNode(**asdict(entry)) for entry in self._runnable.palette(kind))
        except SkirosError as error:
            _log.warning("%s", error)
            return ()

    def all(self, kind: str) -> Documents:
        """Lists the documents of a kind, by id.

        Raises:
            NotFound: There is no such kind.
        """
        with addressed():
            return Documents(documents=tuple(map(_info, self._runnable.all(kind))))

    def get(self, kind: str, id_: str) -> DocumentInfo:
        """Returns a document as it is now.

        Raises:
            NotFound: There is none.
        """
        with addressed():
            return _info(self._runnable.find(kind, id_))

    def revisions(self, kind: str, id_: str) -> Documents:
        """Lists all revisions of a document, oldest first.

        Raises:
            NotFound: There is no such kind.
        """
        with addressed():
            return Documents(documents=tuple(map(_info, self._runnable.revisions(kind, id_))))

    def put(self, kind: str, id_: str, data: Any, seen: Seen | None = ANY_VERSION) -> tuple[DocumentInfo, bool]:
        """Writes a document; returns it, and True if it is new. Its next run uses this revision.

        Raises:
            NotFound: There is no such kind.
            UsageError: It is not valid; the text gives the location of each fault.
            StaleVersion: It was changed since it was seen.
        """
        with addressed():
            known = self._runnable.get(kind, id_)
        if known is not None:
            require_seen(seen, known.version)
        expects = 0 if known is None else known.version
        written = self._runnable.write(kind, id_, data, expects=expects)
        self._station.alarm_book.clear(AlarmKind.MODULE, f"{kind}:{id_}")
        return _info(written), known is None

    def remove(self, kind: str, id_: str, seen: Seen | None = ANY_VERSION) -> None:
        """Removes a document; its active runs continue.

        Raises:
            NotFound: There is none.
            StaleVersion: It was changed since it was seen.
        """
        with addressed():
            known = self._runnable.find(kind, id_)
        require_seen(seen, known.version)
        self._runnable.remove(kind, id_, expects=known.version)
        self._station.alarm_book.clear(AlarmKind.MODULE, f"{kind}:{id_}")


def _info(document: Document) -> DocumentInfo:
    kind, name = document.kind, document.name
    return DocumentInfo(kind=kind, id=name, revision=document.version, module=f"{kind}:{name}", data=document.data)
