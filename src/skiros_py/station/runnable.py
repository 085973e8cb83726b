"""Documents that robots run: checked when they are written, stored with revisions, offered as modules at once."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

from skiros_py.behaviours import DocumentFault, DocumentKind, PaletteEntry
from skiros_py.errors import UnknownName, UsageError
from skiros_py.execution.behaviour_run import RunnableDocument
from skiros_py.skills.plain import Reader
from skiros_py.station.documents import Document, DocumentStore
from skiros_py.station.session import Session

_log = logging.getLogger(__name__)


class RunnableDocuments:
    """The documents of a station, of all kinds that plug-ins bring.

    Each runs as a module ``{kind}:{id}``, by any skill manager, skill or document, from its next start on; what runs
    already goes on as it began. Its revision is kept in the events of the run.

    Args:
        store: Where they are kept.
        session: Whose managers run them.
    """

    def __init__(self, store: DocumentStore, session: Session) -> None:
        self._store = store
        self._session = session
        catalogue = session.catalogue
        self._reader = Reader(catalogue.behaviours, catalogue.conditions)
        self._kinds = catalogue.documents
        for kind in self._kinds:
            for document in store.all(kind):
                self._offer(document)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of the kinds there are."""
        return tuple(sorted(self._kinds))

    def palette(self, kind: str) -> Sequence[PaletteEntry]:
        """Returns the nodes that an editor of such documents offers.

        Raises:
            UnknownName: There is no such kind.
        """
        return self._kind(kind).palette(self._reader)

    def formats(self, kind: str) -> tuple[str, ...]:
        """Returns the text formats in which such documents are imported and exported.

        Raises:
            UnknownName: There is no such kind.
        """
        return self._kind(kind).formats

    def check(self, kind: str, data: Any) -> tuple[DocumentFault, ...]:
        """Returns what is wrong with a document, each with its place.

        Raises:
            UnknownName: There is no such kind.
        """
        return self._kind(kind).check(data, self._reader)

    def all(self, kind: str) -> tuple[Document, ...]:
        """Returns the documents of a kind, by name.

        Raises:
            UnknownName: There is no such kind.
        """
        self._kind(kind)
        return self._store.all(kind)

    def get(self, kind: str, name: str) -> Document | None:
        """Returns a document as it is now; None where there is none.

        Raises:
            UnknownName: There is no such kind.
        """
        self._kind(kind)
        return self._store.get(kind, name)

    def find(self, kind: str, name: str) -> Document:
        """Returns a document as it is now.

        Raises:
            UnknownName: There is none.
        """
        self._kind(kind)
        return self._store.find(kind, name)

    def revisions(self, kind: str, name: str) -> tuple[Document, ...]:
        """Returns all revisions of a document, the oldest first.

        Raises:
            UnknownName: There is no such kind.
        """
        self._kind(kind)
        return self._store.revisions(kind, name)

    def write(self, kind: str, name: str, data: Any, *, expects: int | None = None) -> Document:
        """Writes a document, new or a further revision; its next run is of this one.

        Args:
            kind: Its kind.
            name: Its name.
            data: The document, as plain data.
            expects: The revision that it replaces; 0 where there must be none yet. None for any.

        Raises:
            UnknownName: There is no such kind.
            UsageError: Something is wrong with it; the text names each place.
            StaleVersion: Another revision is there.
        """
        faults = self.check(kind, data)
        if faults:
            raise UsageError(f"{kind} '{name}': {'; '.join(map(str, faults))}")
        document = self._store.put(kind, name, data, expects=expects)
        self._offer(document)
        return document

    def remove(self, kind: str, name: str, *, expects: int | None = None) -> None:
        """Removes a document; its revisions are kept.

        Raises:
            StaleVersion: Another revision is there than is expected.
        """
        self._store.remove(kind, name, expects=expects)
        self._session.managers.documents.pop(f"{kind}:{name}", None)

    def text(self, kind: str, name: str, format_: str = "json") -> str:
        """Exports a document as text.

        Raises:
            UnknownName: There is no such document or format.
        """
        return self._kind(kind).export(self.find(kind, name).data, format_)

    def read(self, kind: str, name: str, text: str, format_: str = "json") -> Document:
        """Imports a document from text; as :meth:`write`.

        Raises:
            UsageError: It is not well-formed, or something is wrong with it.
        """
        return self.write(kind, name, self._kind(kind).parse(text, format_))

    def _offer(self, document: Document) -> None:
        kind = self._kind(document.kind)
        faults = kind.check(document.data, self._reader)
        if faults:
            _log.warning("%s '%s' cannot run: %s", document.kind, document.name, "; ".join(map(str, faults)))
            return
        behaviour, interface = kind.behaviour(document.data, self._reader), kind.interface(document.data)
        self._session.managers.documents[f"{document.kind}:{document.name}"] = RunnableDocument(
            behaviour, document.version, behaviour.title, interface.params, interface.outputs
        )

    def _kind(self, name: str) -> DocumentKind:
        if name not in self._kinds:
            raise UnknownName("kind of document", name, tuple(self._kinds))
        return self._kinds[name]()
