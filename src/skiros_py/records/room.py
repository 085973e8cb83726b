"""The room that a record takes: the oldest becomes coarser, and then goes, before it is too much."""

from __future__ import annotations

import math
from sqlite3 import Connection

from skiros_py.records.frames import key_block
from skiros_py.records.schema import THINNED

__all__ = ["Room"]

_FULL = 0.8
"""Share of the limit from which on something is thinned out; the rest is for what comes meanwhile."""
_ROUNDS = 20


class Room:
    """Keeps a record within its limit.

    Args:
        limit: Bytes that the file takes at most.

    Attributes:
        largest: Bytes that one thing may take.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self.largest = limit // 8

    def note(self, db: Connection, what: str, count: int) -> None:
        """Notes that something was left out."""
        if count:
            sql = "INSERT INTO forgotten VALUES (?, ?) ON CONFLICT (what) DO UPDATE SET count = count + excluded.count"
            db.execute(sql, (what, count))

    def keep(self, db: Connection) -> None:
        """Thins out what takes the most room, the oldest first, until there is room again."""
        for _ in range(_ROUNDS):
            if _used(db) <= self._limit * _FULL:
                return
            sizes = {table: _size(db, table) for table in THINNED}
            self._thin(db, max(sizes, key=lambda table: sizes[table]))

    def _thin(self, db: Connection, table: str) -> None:
        """Takes every second one of the older half away; of changes the whole half, for gaps would be lies."""
        if table == "frames" and self._leave_keys(db):
            return
        ids = [row for (row,) in db.execute(f"SELECT id FROM {table} ORDER BY id")]  # noqa: S608 - our own names
        older = ids[: math.ceil(len(ids) / 2)]
        going = older if table == "changes" else older[1::2] or older
        db.executemany(f"DELETE FROM {table} WHERE id = ?", ((one,) for one in going))  # noqa: S608 - the same
        self.note(db, table, len(going))

    def _leave_keys(self, db: Connection) -> bool:
        """Leaves one snapshot of each block in the older half of those that are whole; False when there are none."""
        whole = db.execute("SELECT id, data FROM frames WHERE thinned = 0 ORDER BY id").fetchall()
        older = [(row, *key_block(data)) for row, data in whole[: math.ceil(len(whole) / 2)]]
        db.executemany("UPDATE frames SET thinned = 1, data = ? WHERE id = ?", ((key, row) for row, key, _ in older))
        self.note(db, "snapshots", sum(gone for _, _, gone in older))
        return bool(older)


def _used(db: Connection) -> int:
    """Returns the bytes of the file that are in use."""
    names = "page_count", "freelist_count", "page_size"
    pages, free, size = (db.execute(f"PRAGMA {name}").fetchone()[0] for name in names)
    return int((pages - free) * size)


def _size(db: Connection, table: str) -> int:
    sql = f"SELECT coalesce(sum(length(data)), 0) FROM {table}"  # noqa: S608 - our own names
    ((size,),) = db.execute(sql).fetchall()
    return int(size)
