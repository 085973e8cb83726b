"""The audit log on the wire."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.wire import Answer, Moment


class AuditRecord(Answer):
    """One request that changed something, or was refused."""

    number: int = Field(description="Counts them.", examples=[17])
    at: Moment = Field(description="When.", examples=["2026-11-21T10:00:00Z"])
    caller: str = Field(description="Name of who made it; empty for strangers.", examples=["line 1 MES"])
    role: str = Field(description="Their role; empty for strangers.", examples=["mes"])
    key: str = Field(description="Id of their key; empty where none was needed.", examples=["1f0c55a2"])
    address: str = Field(description="The address it came from.", examples=["192.0.2.7"])
    method: str = Field(description="HTTP method.", examples=["POST"])
    path: str = Field(description="What it was about.", examples=["/api/v1/jobs/kit-17/abort"])
    operation: str = Field(description="Which operation; empty where it did not get so far.", examples=["abort_job"])
    status: int = Field(description="HTTP status of the answer.", examples=[200])
    request: str = Field(description="Id of the request; the server's log has the same.", examples=["9f3a5c0e1b2d4f66"])
    job: str = Field(description="Id of the job that it was about; empty where none.", examples=["kit-17"])
    comment: str = Field(description="What the caller said about it.", examples=["wrong kit"])


class AuditPage(Answer):
    """Some of the audit log, the youngest entry first."""

    items: list[AuditRecord] = Field(description="The entries.")
    next: str | None = Field(default=None, description="Cursor of the next page; null on the last.", examples=["17"])
