"""The audit log: who changed what, and who was refused."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Query

from skiros_py.api.access import AuditPage, AuditRecord
from skiros_py.api.wire import moment
from skiros_py.server.access.audit import AuditEntry
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.services import ServicesDep

router = APIRouter(prefix="/audit", tags=["access"])

Limit = Annotated[int, Query(ge=1, le=1000, description="At most so many.")]
Cursor = Annotated[str | None, Query(pattern="^[0-9]{1,18}$", description="From the page before.")]


@router.get("", summary="Who did what", dependencies=[needs(Role.ADMIN)])
def list_audit(services: ServicesDep, limit: Limit = 100, cursor: Cursor = None) -> AuditPage:
    """Lists requests that changed something or were refused, the youngest first. The last 100,000 are kept.

    Keys and bodies are never in it. Of one address, 30 refusals in a minute are written down.
    """
    entries = services.audit.page(int(cursor) if cursor is not None else None, limit)
    next_ = str(entries[-1][0]) if len(entries) == limit else None
    return AuditPage(items=[_record(number, entry) for number, entry in entries], next=next_)


def _record(number: int, entry: AuditEntry) -> AuditRecord:
    return AuditRecord.model_validate({"number": number, "at": moment(entry.wall), **asdict(entry)})
