"""Documents: stored plain data such as goal templates, and those that robots run."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from skiros_py.api.alarms import AlarmKind
from skiros_py.api.modules import DocumentInfo, DocumentKindInfo, DocumentKinds, Documents, PaletteNode
from skiros_py.behaviours import Behaviour, DocumentFault, DocumentKind, Interface, PaletteEntry
from skiros_py.database import Database, Schema
from skiros_py.errors import FileError, SkirosError, StaleVersion, UnknownName, UsageError
from skiros_py.execution.running import RunnableDocument
from skiros_py.skills.lint.checking import faults_of_document
from skiros_py.skills.lint.rule import Known
from skiros_py.skills.plain import Reader
from skiros_py.station.requests import ANY_VERSION, Seen, addressed, require_seen
from skiros_py.station.session import Session

if TYPE_CHECKING:
    from skiros_py.station.station import Station


TEMPLATE, SEQUENCE = "goal template", "sequence"
TOLD = (TEMPLATE, SEQUENCE)
"""The kinds of documents that are visible to callers, and whose changes are announced."""

_TABLES = """
CREATE TABLE documents (
    kind TEXT NOT NULL, name TEXT NOT NULL, version INTEGER NOT NULL, data TEXT NOT NULL, PRIMARY KEY (kind, name)
) WITHOUT ROWID;
CREATE TABLE versions (last INTEGER NOT NULL);
INSERT INTO versions VALUES (0);
"""
_REVISIONS = """
CREATE TABLE revisions (
    kind TEXT NOT NULL, name TEXT NOT NULL, version INTEGER NOT NULL, data TEXT NOT NULL,
    PRIMARY KEY (kind, name, version)
) WITHOUT ROWID;
INSERT INTO revisions SELECT kind, name, version, data FROM documents;
"""

_SCHEMA = Schema("list of documents", "the documents of a server", 0x736B7376, (_TABLES, _REVISIONS))
"""Application id of such a file: "sksv"."""

_REVISIONS_KEPT = 50
"""Number of latest revisions kept of each document; recordings contain the documents that ran."""
_FORGET = """
DELETE FROM revisions WHERE kind = ? AND name = ? AND version NOT IN (
    SELECT version FROM revisions WHERE kind = ? AND name = ? ORDER BY version DESC LIMIT ?
)
"""


@dataclass(frozen=True, slots=True)
class Document:
    """One document as it is now.

    Attributes:
        kind: Its kind, such as "goal template" or "sequence".
        name: Its name, unique for its kind.
        version: Its version, unique over all versions of all documents, even if one is removed and created again.
        data: Its content, as JSON data.
    """

    kind: str
    name: str
    version: int
    data: Any


Tell = Callable[[Literal["written", "removed"], Document], None]
"""Listener, called with a document that was written or removed."""


def _nobody(_what: str, _document: Document) -> None:
    """Default listener; does nothing."""


class DocumentStore:
    """The documents of a data directory; thread-safe. Close it.

    Args:
        path: The file; created if missing.
        tell: Called with each document written or removed, in the thread that did it.

    Raises:
        FileError: It cannot be opened or created, or is damaged.
    """

    def __init__(self, path: Path, tell: Tell = _nobody) -> None:
        self._tell = tell
        self._database = Database(path, _SCHEMA, durable=True)
        self._path = path

    def all(self, kind: str) -> tuple[Document, ...]:
        """Returns the documents of a kind, by name."""
        rows = self._database.rows("SELECT name, version, data FROM documents WHERE kind = ? ORDER BY name", (kind,))
        return tuple(self._document(kind, *row) for row in rows)

    def get(self, kind: str, name: str) -> Document | None:
        """Returns a document; None if there is none."""
        rows = self._database.rows("SELECT version, data FROM documents WHERE kind = ? AND name = ?", (kind, name))
        return next((self._document(kind, name, *row) for row in rows), None)

    def find(self, kind: str, name: str) -> Document:
        """Returns a document.

        Raises:
            UnknownName: There is none.
        """
        found = self.get(kind, name)
        if found is None:
            raise UnknownName(kind, name, [document.name for document in self.all(kind)])
        return found

    def revisions(self, kind: str, name: str) -> tuple[Document, ...]:
        """Returns the last revisions of a document, oldest first, also of a removed one."""
        rows = self._database.rows(
            "SELECT version, data FROM revisions WHERE kind = ? AND name = ? ORDER BY version", (kind, name)
        )
        return tuple(self._document(kind, name, *row) for row in rows)

    def put(self, kind: str, name: str, data: Any, *, expects: int | None = None) -> Document:
        """Writes a new document or replaces an existing one; when this returns, it is on disk.

        Args:
            kind: Its kind.
            name: Its name.
            data: Its content, as JSON data.
            expects: The version that it replaces; 0 if there must be none yet; None for any.

        Raises:
            StaleVersion: The present version is a different one.
        """
        text = json.dumps(data)
        with self._database.transaction() as connection:
            self._check(kind, name, expects)
            ((version,),) = connection.execute("UPDATE versions SET last = last + 1 RETURNING last").fetchall()
            connection.execute(
                "INSERT OR REPLACE INTO documents (kind, name, version, data) VALUES (?, ?, ?, ?)",
                (kind, name, version, text),
            )
            connection.execute("INSERT INTO revisions VALUES (?, ?, ?, ?)", (kind, name, version, text))
            connection.execute(_FORGET, (kind, name, kind, name, _REVISIONS_KEPT))
        document = Document(kind, name, int(version), data)
        self._tell("written", document)
        return document

    def remove(self, kind: str, name: str, *, expects: int | None = None) -> None:
        """Removes a document; has no effect if there is none.

        Raises:
            StaleVersion: The present version is not the expected one.
        """
        with self._database.transaction() as connection:
            self._check(kind, name, expects)
            gone = connection.execute(
                "DELETE FROM documents WHERE kind = ? AND name = ? RETURNING version", (kind, name)
            ).fetchall()
        for (version,) in gone:
            self._tell("removed", Document(kind, name, int(version), None))

    def close(self) -> None:
        """Closes the file; may be called twice."""
        self._database.close()

    def _check(self, kind: str, name: str, expects: int | None) -> None:
        if expects is None:
            return
        found = self.get(kind, name)
        now = found.version if found is not None else 0
        if now != expects:
            said = f"version {now} is there" if now else "there is none"
            raise StaleVersion(f"{kind} '{name}': {said}, not version {expects}: it was changed since; look again")

    def _document(self, kind: str, name: str, version: int, data: str) -> Document:
        try:
            return Document(kind, name, version, json.loads(data))
        except ValueError as error:
            raise FileError(self._path, f"the {kind} '{name}' in it cannot be read: {error}") from error


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
        maker = self._kind(kind)
        faults = maker.check(data, self._reader)
        return faults or self._wrong_uses(maker.behaviour(data, self._reader), maker.interface(data), set())

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
        made = behaviour, _, interface = self._made(kind, name, data)
        if faults := self._wrong_uses(behaviour, interface, {f"{kind}:{name}"}):
            raise UsageError(f"{kind} '{name}': {'; '.join(map(str, faults))}")
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

    def _wrong_uses(self, body: Behaviour, interface: Interface, modules: set[str]) -> tuple[DocumentFault, ...]:
        """Returns what a document asks of this station that it does not offer; it may call the given modules, too."""
        catalogue, ontology = self._session.catalogue, self._session.world.ontology
        known = Known(ontology, catalogue.primitives, tuple(catalogue.skills.values()), catalogue.reasoners)
        documents = modules | {f"{kind}:{one.name}" for kind in self._kinds for one in self._store.all(kind)}
        return tuple(DocumentFault(*fault) for fault in faults_of_document(body, interface.params, known, documents))

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
