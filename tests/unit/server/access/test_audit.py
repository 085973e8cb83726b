"""The audit log."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from skiros_py.server.access import audit as audit_module
from skiros_py.server.access.audit import AuditLog
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
    rest = log.page(before=first[-1].number, limit=3)

    assert [entry.path for entry in (*first, *rest)] == [f"/{number}" for number in (4, 3, 2, 1, 0)]


def test_audit_entries_are_stored_when_the_log_is_closed(tmp_path: Path) -> None:
    log = AuditLog(open_access(tmp_path))
    log.start()
    log.append(_entry(1))
    log.close()

    with closing(AuditLog(open_access(tmp_path))) as again:
        (entry,) = again.page()

    assert (entry.path, entry.at.timestamp()) == ("/1", 1e9 + 1)


def test_the_size_of_the_audit_log_is_bounded(log: AuditLog, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audit_module, "_KEPT", 10)
    for number in range(2500):
        log.append(_entry(number))

    kept = log.page(limit=1000)

    assert [entry.path for entry in kept] == [f"/{number}" for number in range(2499, 2489, -1)]


def test_additional_work_of_the_writer_is_done_on_closing_too(tmp_path: Path) -> None:
    done = []
    AuditLog(open_access(tmp_path), besides=lambda _database: done.append(True)).close()

    assert done
