"""The server itself: keys, the caller's session, the audit log, its health, and how local programs find it."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from skiros_py.api.wire import Answer, Moment, Request, WantedMoment

RoleName = Literal["viewer", "operator", "engineer", "admin", "mes"]
"""What somebody may do. Each of the first four may do what those before it may; mes may order and command jobs."""


class KeyOrder(Request):
    """A wish for a key."""

    name: str = Field(
        min_length=1,
        max_length=100,
        description="Who gets it; author of what they write.",
        examples=["line 1 MES"],
    )
    role: RoleName = Field(description="What they may do.", examples=["mes"])
    expires: WantedMoment | None = Field(
        default=None,
        description="From when on it is not valid any more; never where left out.",
        examples=["2030-01-01T00:00:00Z"],
    )


class ApiKey(Answer):
    """A key, without what is secret about it."""

    id: str = Field(description="Names it.", examples=["1f0c55a2"])
    name: str = Field(description="Who has it.", examples=["line 1 MES"])
    role: RoleName = Field(description="What they may do.", examples=["mes"])
    shown: str = Field(description="Its beginning and its end, to tell keys apart.", examples=["sk_1f0c55a2_…Zw4k"])
    created: Moment = Field(description="When it was made.", examples=["2026-11-21T10:00:00Z"])
    expires: Moment | None = Field(default=None, description="From when on it is not valid; null for never.")
    revoked: Moment | None = Field(default=None, description="When it was revoked; null while it is not.")
    used: Moment | None = Field(default=None, description="When it was last used, about; null before that.")
    valid: bool = Field(description="True while it opens the door.", examples=[True])


class NewKey(Answer):
    """A key that was just made."""

    key: ApiKey = Field(description="What is known of it from now on.")
    secret: str = Field(
        description="The key itself. It is shown this once, and kept nowhere.", examples=["sk_1f0c55a2_…"], repr=False
    )


class Login(Request):
    """A key, shown once by a web page, which gets a cookie for it."""

    key: str = Field(min_length=1, max_length=200, description="The key.", examples=["sk_1f0c55a2_…"], repr=False)


class Me(Answer):
    """Who the caller is."""

    name: str = Field(description="Their name; author of what they write.", examples=["anna"])
    role: RoleName = Field(description="What they may do, in one word.", examples=["operator"])
    key: str = Field(description="Id of their key; empty where none is needed.", examples=["1f0c55a2"])
    keys_needed: bool = Field(description="True if every request needs a key.", examples=[True])
    operations: list[str] = Field(
        description="What they may do, as operation ids of the API's description.", examples=[["list_jobs"]]
    )


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


class Health(Answer):
    """Whether the server is alive."""

    alive: bool = Field(description="True while the control cycle goes round.", examples=[True])
    why: str = Field(default="", description="What is wrong; empty in good times.")


class Readiness(Answer):
    """Whether orders can be fulfilled."""

    ready: bool = Field(description="True while the station is open and what is ordered can be kept.", examples=[True])
    halted: bool = Field(default=False, description="True while everything is halted: orders are kept and wait.")
    why: str = Field(default="", description="What is wrong; empty in good times.")


SERVER_FILE = "server.json"
"""Lies in the data directory while a server runs on it; only its user can read it."""


class LocalServer(BaseModel):
    """A server that runs on a data directory of this machine.

    Attributes:
        url: Its address.
        pid: Its process.
        token: A key of an administrator that counts until it ends.
    """

    model_config = ConfigDict(frozen=True)

    url: str = Field(description="Its address.", examples=["http://127.0.0.1:8000"])
    pid: int = Field(description="Its process.", examples=[4711])
    token: str = Field(description="A key of an administrator that counts until it ends.", repr=False)
