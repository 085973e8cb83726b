"""The audit log."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from skiros_py.database import Schema
from skiros_py.database_file import DatabaseFile
from skiros_py.server.access import audit as audit_module
from skiros_py.server.access import keys
from skiros_py.server.access.audit import AuditLog, broken_link
from skiros_py.server.access.keys import open_access


def _entry(number: int) -> dict[str, Any]:
    texts = dict.fromkeys(("caller", "role", "key", "address", "method", "operation", "request", "job", "comment"), "x")
    return {**texts, "wall": 1e9 + number, "path": f"/{number}", "status": 200}


@pytest.fixture
def log(tmp_path: Path) -> Iterator[AuditLog]:
    with closing(AuditLog(open_access(tmp_path))) as opened:
        yield opened


def test_audit_entries_are_read_page_by_page_from_the_newest(log: AuditLog) -> None:
    for number in range(5):
        log.append(_entry(number))

    first = log.page(limit=3)
    assert first.next is not None
    rest = log.page(before=int(first.next), limit=3)

    assert rest.next is None
    assert [entry.path for entry in (*first.items, *rest.items)] == [f"/{number}" for number in (4, 3, 2, 1, 0)]


def test_audit_entries_are_stored_when_the_log_is_closed(tmp_path: Path) -> None:
    log = AuditLog(open_access(tmp_path))
    log.start()
    log.append(_entry(1))
    log.close()

    with closing(AuditLog(open_access(tmp_path))) as again:
        (entry,) = again.page().items

    assert (entry.path, entry.at.timestamp()) == ("/1", 1e9 + 1)


@pytest.mark.parametrize(
    "damage", ["'{'", "'[]'", "'{}'", "replace(data, 'status', 'statas')", "CAST(x'7bff7d' AS TEXT)", "x'00'"]
)
def test_a_damaged_audit_record_is_named_left_out_and_hides_no_other(
    log: AuditLog, tmp_path: Path, damage: str
) -> None:
    for number in range(5):
        log.append(_entry(number))
    log.page()
    with closing(open_access(tmp_path)) as database, database.transaction() as connection:
        connection.execute(f"UPDATE audit SET data = {damage} WHERE number IN (2, 3)")

    seen, before = [], None
    while (page := log.page(before=before, limit=2)).next is not None:
        seen += page.items
        before = int(page.next)

    assert [entry.number for entry in (*seen, *page.items)] == [5, 4, 1]
    assert set(log.unreadable) == {"record 2 of the audit log", "record 3 of the audit log"}


def test_the_size_of_the_audit_log_is_bounded(log: AuditLog, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audit_module, "_KEPT", 10)
    for number in range(2500):
        log.append(_entry(number))

    kept = log.page(limit=1000).items

    assert [entry.path for entry in kept] == [f"/{number}" for number in range(2499, 2489, -1)]


def test_rotation_keeps_the_chain_and_the_first_broken_record_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(audit_module, "_KEPT", 10)
    for first in (0, 2000):  # also over a restart
        with closing(AuditLog(open_access(tmp_path))) as log:
            for number in range(first, first + 1500):
                log.append(_entry(number))

    def broken() -> str:
        with closing(DatabaseFile(tmp_path / "access.db")) as file:
            return broken_link(file)

    assert broken() == ""
    with closing(open_access(tmp_path)) as database, database.transaction() as connection:
        connection.execute("UPDATE audit SET data = replace(data, '200', '500') WHERE number IN (2995, 2997)")
    assert broken().startswith("record 2995 was changed")
    with closing(open_access(tmp_path)) as database, database.transaction() as connection:
        connection.execute("DELETE FROM audit WHERE number < 2993")
    assert broken() == "record 2991 was removed"


def test_records_of_an_older_version_are_kept_and_the_chain_begins_after_them(tmp_path: Path) -> None:
    old = Schema("the keys of a server", keys._SCHEMA.application, keys._SCHEMA.migrations[:1])
    with closing(sqlite3.connect(tmp_path / "access.db")) as connection:
        old.upgrade(connection)
        rows = [(json.dumps(_entry(number)),) for number in range(3)]
        connection.executemany("INSERT INTO audit (data) VALUES (?)", rows)
        connection.commit()

    with closing(AuditLog(open_access(tmp_path))) as log:
        log.append(_entry(3))
        assert [(entry.number, entry.path) for entry in log.page().items] == [(n + 1, f"/{n}") for n in (3, 2, 1, 0)]
        assert len(list(log.lines())) == 4
    with closing(DatabaseFile(tmp_path / "access.db")) as file:
        assert broken_link(file) == ""


def test_additional_work_of_the_writer_is_done_on_closing_too(tmp_path: Path) -> None:
    done = []
    AuditLog(open_access(tmp_path), besides=lambda _database: done.append(True)).close()

    assert done
