"""Documents that robots run: checked when they are written, stored with revisions, offered as modules at once."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

from skiros_py.behaviours import Behaviour, DocumentFault, DocumentKind, Interface, PaletteEntry
from skiros_py.errors import SkirosError, UnknownName, UsageError
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

    Attributes:
        set_aside: Why a stored document cannot run, by module; it can be read, replaced and removed.
    """

    def __init__(self, store: DocumentStore, session: Session) -> None:
        self._store = store
        self._session = session
        catalogue = session.catalogue
        self._reader = Reader(catalogue.behaviours, catalogue.conditions)
        self._kinds = catalogue.documents
        self.set_aside: dict[str, str] = {}
        for kind in self._kinds:
            for document in store.all(kind):
                try:
                    self._offer(document, *self._made(kind, document.name, document.data))
                except UsageError as error:
                    _log.warning("%s:%s cannot run: %s", kind, document.name, error)
                    self.set_aside[f"{kind}:{document.name}"] = str(error)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of the kinds there are."""
        return tuple(sorted(self._kinds))

    def palette(self, kind: str) -> Sequence[PaletteEntry]:
        """Returns the nodes that an editor of such documents offers.

        Raises:
            UnknownName: There is no such kind.
            UsageError: The kind breaks.
        """
        try:
            return self._kind(kind).palette(self._reader)
        except SkirosError:
            raise
        except Exception as error:
            raise UsageError(f"the palette of kind {kind}: {type(error).__name__}: {error}") from error

    def formats(self, kind: str) -> tuple[str, ...]:
        """Returns the text formats in which such documents are imported and exported.

        Raises:
            UnknownName: There is no such kind.
        """
        return self._known(kind).formats

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
        self._known(kind)
        return self._store.all(kind)

    def get(self, kind: str, name: str) -> Document | None:
        """Returns a document as it is now; None where there is none.

        Raises:
            UnknownName: There is no such kind.
        """
        self._known(kind)
        return self._store.get(kind, name)

    def find(self, kind: str, name: str) -> Document:
        """Returns a document as it is now.

        Raises:
            UnknownName: There is none.
        """
        self._known(kind)
        return self._store.find(kind, name)

    def revisions(self, kind: str, name: str) -> tuple[Document, ...]:
        """Returns all revisions of a document, the oldest first.

        Raises:
            UnknownName: There is no such kind.
        """
        self._known(kind)
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
        made = self._made(kind, name, data)
        document = self._store.put(kind, name, data, expects=expects)
        self._offer(document, *made)
        return document

    def remove(self, kind: str, name: str, *, expects: int | None = None) -> None:
        """Removes a document; its revisions are kept.

        Raises:
            StaleVersion: Another revision is there than is expected.
        """
        self._store.remove(kind, name, expects=expects)
        self._session.managers.documents.pop(f"{kind}:{name}", None)
        self.set_aside.pop(f"{kind}:{name}", None)

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

    def _made(self, kind: str, name: str, data: Any) -> tuple[Behaviour, str, Interface]:
        """Returns what a document does, its title and its interface.

        Raises:
            UsageError: Something is wrong with it, or its kind breaks; the text names kind, document and reason.
        """
        maker = self._kind(kind)
        try:
            faults = maker.check(data, self._reader)
            if not faults:
                behaviour = maker.behaviour(data, self._reader)
                return behaviour, behaviour.title, maker.interface(data)
        except Exception as error:
            raise UsageError(f"{kind} '{name}': {type(error).__name__}: {error}") from error
        raise UsageError(f"{kind} '{name}': {'; '.join(map(str, faults))}")

    def _offer(self, document: Document, behaviour: Behaviour, title: str, interface: Interface) -> None:
        module = f"{document.kind}:{document.name}"
        self.set_aside.pop(module, None)
        self._session.managers.documents[module] = RunnableDocument(
            behaviour, document.version, title, interface.params, interface.outputs
        )

    def _known(self, name: str) -> type[DocumentKind]:
        if name not in self._kinds:
            raise UnknownName("kind of document", name, tuple(self._kinds))
        return self._kinds[name]

    def _kind(self, name: str) -> DocumentKind:
        try:
            return self._known(name)()
        except SkirosError:
            raise
        except Exception as error:
            raise UsageError(f"documents of kind {name}: {type(error).__name__}: {error}") from error
