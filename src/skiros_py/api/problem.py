"""What is said when a request cannot be fulfilled (RFC 9457, ``application/problem+json``)."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class ProblemDetails(BaseModel):
    """What went wrong, and what would be right.

    Attributes:
        type: The kind of problem, as a name (``urn:skiros:problem:<code>``): to be compared, not fetched.
        title: The kind of problem in words; the same for all of a kind.
        status: The HTTP status.
        detail: What is wrong with this request, and what would be right.
        code: The kind of problem, for programs ("UnknownJobOrderID", "InvalidJobOrderStatus", ...).
        instance: Which request it was; the server's log has the same.
        return_status: ISA-95 return status of a job command, as a bit map (OPC 10031-4 v2.00, annex B.2).
        errors: Which fields are wrong, and why.
    """

    model_config = ConfigDict(extra="allow")

    type: str = "about:blank"
    title: str
    status: int
    detail: str = ""
    code: str = ""
    instance: str = ""
    return_status: int | None = None
    errors: list[dict[str, Any]] = Field(default_factory=list)
