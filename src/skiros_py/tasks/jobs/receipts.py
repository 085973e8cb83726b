"""What somebody's request led to: whoever asks once more, since the answer was lost, gets the same answer."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass

from skiros_py.errors import KeyReused

KEPT = 24 * 3600.0
"""How long a receipt is kept at least [s]."""


@dataclass(frozen=True, slots=True)
class Receipt:
    """Marks a request, so that the same one is known again.

    Attributes:
        caller: Who asks; keys of different callers have nothing to do with each other.
        key: Chosen by the caller, another one for each request.
        digest: Stands for the content of the request.
    """

    caller: str
    key: str
    digest: str

    def check(self, digest: str) -> None:
        """Sees that this is the request that was kept under the key.

        Raises:
            KeyReused: It is another one.
        """
        if digest != self.digest:
            raise KeyReused(f"the key '{self.key}' was used for another order: take a new key for each new order")


def keep_receipt(connection: sqlite3.Connection, receipt: Receipt, job: str, wall: float) -> None:
    """Keeps that a request led to a job, and forgets what is old."""
    connection.execute("DELETE FROM receipts WHERE wall < ?", (wall - KEPT,))
    values = (receipt.caller, receipt.key, receipt.digest, job, wall)
    connection.execute("INSERT INTO receipts (caller, key, digest, job, wall) VALUES (?, ?, ?, ?, ?)", values)


def leave_receipts(connection: sqlite3.Connection, job: str, data: str) -> None:
    """Keeps the last version of a job that is removed with the receipts that led to it."""
    connection.execute("UPDATE receipts SET last = ? WHERE job = ? AND last IS NULL", (data, job))
