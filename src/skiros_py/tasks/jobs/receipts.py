"""Results of requests: a client that repeats a request because the answer was lost gets the same answer."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass

from skiros_py.errors import KeyReused

KEPT = 24 * 3600.0
"""How long a receipt is kept at least [s]."""


@dataclass(frozen=True, slots=True)
class Receipt:
    """Identifies a request, so that a repetition is recognized.

    Attributes:
        caller: The caller; keys of different callers are independent.
        key: Chosen by the caller, unique per request.
        digest: Digest of the request's content.
    """

    caller: str
    key: str
    digest: str

    def check(self, digest: str) -> None:
        """Checks that this is the request stored under the key.

        Raises:
            KeyReused: It is another one.
        """
        if digest != self.digest:
            raise KeyReused(f"the key '{self.key}' was used for another order: take a new key for each new order")


def keep_receipt(connection: sqlite3.Connection, receipt: Receipt, job: str, wall: float) -> None:
    """Stores that a request led to a job and deletes old receipts."""
    connection.execute("DELETE FROM receipts WHERE wall < ?", (wall - KEPT,))
    values = (receipt.caller, receipt.key, receipt.digest, job, wall)
    connection.execute("INSERT INTO receipts (caller, key, digest, job, wall) VALUES (?, ?, ?, ?, ?)", values)


def leave_receipts(connection: sqlite3.Connection, job: str, data: str) -> None:
    """Stores the last version of a removed job with the receipts that led to it."""
    connection.execute("UPDATE receipts SET last = ? WHERE job = ? AND last IS NULL", (data, job))
