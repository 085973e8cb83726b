"""The store of documents: plain data of all kinds, with revisions, in one file of the data directory."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from skiros_py.database import COUNTED, Database, Schema
from skiros_py.errors import StaleVersion, UnknownName
from skiros_py.messages import Message

TEMPLATE, SEQUENCE = "template", "sequence"
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

_RENAMED = """
UPDATE documents SET kind = 'template' WHERE kind = 'goal template';
UPDATE revisions SET kind = 'template' WHERE kind = 'goal template';
"""

_SCHEMA = Schema(Message("the documents of a server"), 0x736B7376, (_TABLES, _REVISIONS, _RENAMED, COUNTED))
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
        kind: Its kind, such as "template" or "sequence".
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


def _ignore(_what: str, _document: Document) -> None:
    """Default listener; does nothing."""


class DocumentStore:
    """The documents of a data directory; thread-safe. Close it.

    Args:
        path: The file; created if missing.
        tell: Called with each document written or removed, in the thread that did it.

    Raises:
        FileError: It cannot be opened or created, or is damaged.

    Attributes:
        unreadable: The documents that were left out because they cannot be read, by name.
    """

    def __init__(self, path: Path, tell: Tell = _ignore) -> None:
        self._tell = tell
        self._database = Database(path, _SCHEMA, durable=True)
        self.unreadable = self._database.unreadable

    def all(self, kind: str) -> tuple[Document, ...]:
        """Returns the documents of a kind that can be read, by name."""
        return self._readable("SELECT name, version, data FROM documents WHERE kind = ? ORDER BY name", kind)

    def get(self, kind: str, name: str) -> Document | None:
        """Returns a document; None if there is none."""
        rows = self._database.rows("SELECT version, data FROM documents WHERE kind = ? AND name = ?", (kind, name))
        return next((self._database.read(_name(kind, name), _document, kind, name, *row) for row in rows), None)

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
        sql = "SELECT name, version, data FROM revisions WHERE kind = ? AND name = ? ORDER BY version"
        return self._readable(sql, kind, name)

    def put(self, kind: str, name: str, data: Any, *, expects: int | None = None) -> Document:
        """Writes a new document or replaces an existing one; when this returns, it is on disk.

        Args:
            kind: Its kind.
            name: Its name.
            data: Its content, as JSON data.
            expects: The version that it replaces; 0 if there must be none yet; None for any.

        Raises:
            StaleVersion: The current version is a different one.
        """
        text = json.dumps(data)
        with self._database.transaction(f"{kind} {name}, written") as connection:
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
            StaleVersion: The current version is not the expected one.
        """
        with self._database.transaction(f"{kind} {name}, removed") as connection:
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
        rows = self._database.rows("SELECT version FROM documents WHERE kind = ? AND name = ?", (kind, name))
        now = rows[0][0] if rows else 0
        if now != expects:
            said = Message("version {version} is there", version=now) if now else Message("there is none")
            raise StaleVersion(
                Message(
                    "{kind} '{name}': {there}, not version {seen}: it was changed since; look again",
                    kind=kind,
                    name=name,
                    there=said,
                    seen=expects,
                )
            )

    def _readable(self, sql: str, *values: str) -> tuple[Document, ...]:
        """Returns the documents of a query that can be read; its first value is their kind."""
        kind, rows = values[0], self._database.rows(sql, values)
        named = (
            (f"{_name(kind, name)} of version {version}", kind, name, version, data) for name, version, data in rows
        )
        return tuple(self._database.readable(named, _document))


def _name(kind: str, name: str) -> str:
    return f"the {kind} '{name}'"


def _document(kind: str, name: str, version: int, data: str) -> Document:
    return Document(kind, name, version, json.loads(data))
