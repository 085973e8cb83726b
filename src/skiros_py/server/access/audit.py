"""The audit log: who changed what, when and from where, and which requests were refused.

Each record is a line of JSON that holds the SHA-256 of the line before: changed and removed records are noticed.
"""

from __future__ import annotations

import hashlib
import json
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skiros_py.api.server import AuditPage, AuditRecord
from skiros_py.database import Database
from skiros_py.database_file import DatabaseFile
from skiros_py.errors import FileError, SkirosError
from skiros_py.server.access.keys import FILE
from skiros_py.station.data_files import Finding

if TYPE_CHECKING:
    from fastapi import Request

_log = logging.getLogger(__name__)

_KEPT = 100_000
"""Number of entries kept."""
_FORGET = "DELETE FROM audit WHERE number <= (SELECT max(number) FROM audit) - ?"
_WAITING = 20_000
"""Limit of entries waiting to be written: if the disk hangs, the oldest entries are dropped and requests go on."""
_BATCH = 1000
_PAUSE = 0.5
"""Time during which entries are collected before they are written together [s]."""
_IDLE = 10.0
"""Period of the additional work, see ``besides`` [s]."""
_MINUTE = 60.0
_LISTED = 5
_LISTED_OF_ALL = 300
"""Refusals per minute that are listed one by one, of one caller and of all; further ones are only counted."""
_PAGE = 1000


@dataclass(slots=True)
class _Refusals:
    """The refusals of one caller with one status in one minute: how many, and how many more than are listed."""

    since: float
    number: int = 0
    unlisted: int = 0
    last: Mapping[str, Any] | None = None


def note(request: Request, *, job: str = "", comment: str = "") -> None:
    """Adds details to the audit log entry of a request; for routes.

    Args:
        request: The request.
        job: Id of the job that the request concerns, if the path does not contain it.
        comment: What the caller said about it.
    """
    request.state.audit = {"job": job[:200], "comment": comment[:1000]}


class AuditLog:
    """Writes entries in a thread of its own, so that no request waits for the disk. Start it, and close it.

    Args:
        database: From :func:`~skiros_py.server.access.keys.open_access`, its own connection; closed at the end.
        besides: Writes other data from time to time; receives the database.

    Attributes:
        unreadable: The records that were left out because they cannot be read, by name.
    """

    def __init__(self, database: Database, besides: Callable[[Database], None] = lambda _database: None) -> None:
        self._database = database
        self.unreadable = database.unreadable
        self._besides = besides
        self._entries: deque[Mapping[str, Any]] = deque(maxlen=_WAITING)
        self._refusals: dict[tuple[str, int], _Refusals] = {}
        self._counting = threading.Lock()
        self._writing = threading.Lock()
        self._asked = threading.Event()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="skiros-audit", daemon=True)

    def start(self) -> None:
        """Starts the thread."""
        self._thread.start()

    def append(self, entry: Mapping[str, Any]) -> None:
        """Queues an entry for writing; does not block; callable from any thread.

        Args:
            entry: The fields of an :class:`~skiros_py.api.server.AuditRecord`, with its time as ``wall`` [s since
                1970]; contains neither keys nor bodies.
        """
        self._entries.append(entry)
        self._asked.set()

    def append_refusal(self, who: str, entry: Mapping[str, Any]) -> None:
        """Queues an entry about a refused request; after some of one caller in a minute, they are only counted.

        One entry with their number follows then, with the details of the last one.

        Args:
            who: The key or the network of the caller.
            entry: As for :meth:`append`.
        """
        now = time.monotonic()
        with self._counting:
            listed = sum(one.number - one.unlisted for one in self._refusals.values())
            if listed >= _LISTED_OF_ALL and (who, entry["status"]) not in self._refusals:
                who, entry = "", {**entry, **dict.fromkeys(("caller", "role", "key", "address"), "")}
            refusals = self._refusals.setdefault((who, entry["status"]), _Refusals(now))
            refusals.number += 1
            if refusals.number <= _LISTED and listed < _LISTED_OF_ALL:
                self.append(entry)
            else:
                refusals.unlisted, refusals.last = refusals.unlisted + 1, entry

    def _count_refusals(self, *, all_: bool = False) -> None:
        """Queues the entries with the numbers of refusals whose minute is over."""
        end = float("inf") if all_ else time.monotonic() - _MINUTE
        with self._counting:
            over = [(who, one) for who, one in self._refusals.items() if one.since <= end]
            for who, one in over:
                del self._refusals[who]
                if one.last is not None:
                    self.append({**one.last, "count": one.unlisted})

    def page(self, before: int | None = None, limit: int = 100) -> AuditPage:
        """Returns the entries that can be read, newest first.

        Args:
            before: Return only entries with smaller numbers.
            limit: Maximum number of entries.
        """
        self._write()
        end = 2**63 - 1 if before is None else before
        sql = "SELECT 'record ' || number || ' of the audit log', number, data FROM audit"
        rows = self._database.rows(f"{sql} WHERE number < ? ORDER BY number DESC LIMIT ?", (end, limit))
        items = tuple(self._database.readable(rows, _record))
        return AuditPage(items=items, next=str(rows[-1][1]) if len(rows) == limit else None)

    def lines(self) -> Iterator[str]:
        """Returns all records as lines of JSON, oldest first."""
        self._write()
        return exported(self._database)

    def close(self) -> None:
        """Writes the queued entries and closes the file; may be called twice."""
        if self._ending.is_set():
            return
        self._ending.set()
        self._asked.set()
        if self._thread.ident is not None:
            self._thread.join()
        self._count_refusals(all_=True)
        self._keep()
        self._database.close()

    def _run(self) -> None:
        while not self._ending.is_set():
            self._asked.wait(_IDLE)
            self._asked.clear()
            self._ending.wait(_PAUSE)
            self._keep()

    def _keep(self) -> None:
        try:
            self._count_refusals()
            self._write()
            self._besides(self._database)
        except SkirosError as error:
            _log.error("the audit log cannot be written: %s", error)

    def _write(self) -> None:
        with self._writing:
            while batch := [self._entries.popleft() for _ in range(min(_BATCH, len(self._entries)))]:
                try:
                    with self._database.transaction(f"{len(batch)} records of the audit log") as connection:
                        chain = connection.execute("SELECT last, hash FROM audit_chain").fetchall()
                        if len(chain) != 1:
                            raise FileError(self._database.path, "the row of the audit log's chain was removed")
                        ((number, last),) = chain
                        for entry in batch:
                            number += 1
                            line = json.dumps({"number": number, **entry, "previous": last})
                            last = _hash(line)
                            connection.execute("INSERT INTO audit (number, data) VALUES (?, ?)", (number, line))
                        connection.execute("UPDATE audit_chain SET last = ?, hash = ?", (number, last))
                        connection.execute(_FORGET, (_KEPT,))
                except FileError:
                    self._entries.extendleft(reversed(batch))  # they are written later
                    raise


def exported(database: Database | DatabaseFile) -> Iterator[str]:
    """Yields all records of an audit log as lines of JSON, oldest first; each holds the SHA-256 of the line before.

    Args:
        database: The file of keys.
    """
    for _, line in _stored(database):
        yield line


def audit_findings(data: Path) -> Iterator[Finding]:
    """Yields what is wrong with the audit log of a data directory, if there is one; a server may use it."""
    if not (data / FILE).exists():
        return
    try:
        with closing(DatabaseFile(data / FILE)) as file:
            broken = broken_link(file)
    except FileError:  # which is found without the server, too
        return
    if broken:
        advice = "compare with an export of the audit log; any program that can write to the file can do that"
        yield Finding(FILE, f"the audit log was changed afterwards: {broken}", advice)


def broken_link(database: Database | DatabaseFile) -> str:
    """Returns which record of an audit log was the first to be changed or removed; empty if none was.

    Records of older versions of this program, which hold no hash, are not checked.

    Args:
        database: The file of keys.
    """
    if not database.rows("SELECT 1 FROM sqlite_schema WHERE name = 'audit_chain'"):
        return ""
    chain = database.rows("SELECT begins, last, hash FROM audit_chain")
    if len(chain) != 1:
        return "the row of its chain was removed"
    ((begins, last, final),) = chain
    due, hash_before = max(begins, last - _KEPT + 1), ""
    for number, line in _stored(database, begins):
        if number > due:
            return f"record {due} was removed"
        entry = _decoded(line)
        if hash_before and entry.get("previous") != hash_before:
            return f"record {number - 1} was changed, or the hash of it in record {number}"
        if entry.get("number") != number:
            return f"record {number} was changed"
        due, hash_before = number + 1, _hash(line)
    if due <= last:
        return f"record {due} was removed"
    return "" if hash_before in (final, "") else f"record {last} was changed"


def _record(number: int, data: str) -> AuditRecord:
    entry = _decoded(data)
    return AuditRecord.model_validate({**entry, "at": entry.pop("wall", None), "number": number})


def _decoded(line: str) -> dict[str, Any]:
    try:
        entry = json.loads(line)
    except ValueError:
        return {}
    return entry if isinstance(entry, dict) else {}


def _stored(database: Database | DatabaseFile, first: int = 0) -> Iterator[tuple[int, str]]:
    """Yields number and text of the records from a number on."""
    while rows := database.rows(
        "SELECT number, data FROM audit WHERE number >= ? ORDER BY number LIMIT ?", (first, _PAGE)
    ):
        yield from rows
        first = rows[-1][0] + 1


def _hash(line: str) -> str:
    return hashlib.sha256(line.encode()).hexdigest()
