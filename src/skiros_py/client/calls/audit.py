"""The audit log: who changed what, and who was refused."""

from __future__ import annotations

from skiros_py.api.audit import AuditPage
from skiros_py.client.call import Call


def list_audit(limit: int = 100, cursor: str | None = None) -> Call[AuditPage]:
    """Lists requests that changed something or were refused, the youngest first."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/audit", AuditPage, query=query)
