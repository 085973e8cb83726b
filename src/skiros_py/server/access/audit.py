"""The audit log: who changed what, when and from where, and which requests were refused."""

from __future__ import annotations

import json
import logging
import threading
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from fastapi import Request

from skiros_py.api.server import AuditRecord
from skiros_py.database import Database
from skiros_py.errors import DiskFault, SkirosError

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
    """

    def __init__(self, database: Database, besides: Callable[[Database], None] = lambda _database: None) -> None:
        self._database = database
        self._besides = besides
        self._entries: deque[Mapping[str, Any]] = deque(maxlen=_WAITING)
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

    def page(self, before: int | None = None, limit: int = 100) -> list[AuditRecord]:
        """Returns entries, newest first.

        Args:
            before: Return only entries with smaller numbers.
            limit: Maximum number of entries.
        """
        self._write()
        end = 2**63 - 1 if before is None else before
        rows = self._database.rows(
            "SELECT number, data FROM audit WHERE number < ? ORDER BY number DESC LIMIT ?", (end, limit)
        )
        read = ((number, json.loads(data)) for number, data in rows)
        return [AuditRecord(number=number, at=entry.pop("wall"), **entry) for number, entry in read]

    def close(self) -> None:
        """Writes the queued entries and closes the file; may be called twice."""
        if self._ending.is_set():
            return
        self._ending.set()
        self._asked.set()
        if self._thread.ident is not None:
            self._thread.join()
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
            self._write()
            self._besides(self._database)
        except SkirosError as error:
            _log.error("the audit log cannot be written: %s", error)

    def _write(self) -> None:
        with self._writing:
            while batch := [self._entries.popleft() for _ in range(min(_BATCH, len(self._entries)))]:
                rows = [(json.dumps(entry),) for entry in batch]
                try:
                    with self._database.transaction() as connection:
                        connection.executemany("INSERT INTO audit (data) VALUES (?)", rows)
                        connection.execute(_FORGET, (_KEPT,))
                except DiskFault:
                    self._entries.extendleft(reversed(batch))  # they are written later
                    raise
