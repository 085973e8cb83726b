"""The server itself: keys, the caller's session, the audit log, its health, and how local programs find it."""

from __future__ import annotations

import ipaddress
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from skiros_py.api.wire import Answer, Moment, Page, Request, WantedMoment

RoleName = Literal["viewer", "operator", "engineer", "admin", "mes"]
"""The roles. Each of the first four includes the permissions of those before it; mes may order and command jobs."""


class KeyOrder(Request):
    """A request for a key."""

    name: str = Field(min_length=1, max_length=100, examples=["line 1 MES"])
    """Its owner: the author of writes with it."""
    role: RoleName = Field(examples=["mes"])
    """Its role."""
    expires: WantedMoment | None = Field(default=None, examples=["2030-01-01T00:00:00Z"])
    """When it expires; never if omitted."""


class ApiKey(Answer):
    """A key, without the secret."""

    id: str = Field(examples=["1f0c55a2"])
    """Its id."""
    name: str = Field(examples=["line 1 MES"])
    """Its owner."""
    role: RoleName = Field(examples=["mes"])
    """Its role."""
    shown: str = Field(examples=["sk_1f0c55a2_…Zw4k"])
    """Its first and last characters, to distinguish keys."""
    created: Moment = Field(examples=["2026-11-21T10:00:00Z"])
    """When it was created."""
    expires: Moment | None = None
    """When it expires; null for never."""
    revoked: Moment | None = None
    """When it was revoked; null if it was not."""
    used: Moment | None = None
    """When it was last used, approximately; null if never."""
    valid: bool = Field(examples=[True])
    """Whether requests with it are accepted."""


ApiKeys = Page[ApiKey]
"""All keys."""


class NewKey(Answer):
    """A new key."""

    key: ApiKey
    """The key, without the secret."""
    secret: str = Field(examples=["sk_1f0c55a2_…"], repr=False)
    """The secret. It is returned only once and not stored."""


class Login(Request):
    """A login of a web page, which exchanges a key for a cookie."""

    key: str = Field(min_length=1, max_length=200, examples=["sk_1f0c55a2_…"], repr=False)
    """The key."""


class Me(Answer):
    """The caller."""

    name: str = Field(examples=["anna"])
    """Name of the caller: the author of their writes."""
    role: RoleName = Field(examples=["operator"])
    """Their role."""
    key: str = Field(examples=["1f0c55a2"])
    """Id of their key; empty if none is needed."""
    keys_needed: bool = Field(examples=[True])
    """Whether every request needs a key."""
    operations: list[str] = Field(examples=[["list_jobs"]])
    """Permitted operations, as operation ids of the OpenAPI document."""


class AuditRecord(Answer):
    """A request that changed something, or was refused."""

    number: int = Field(examples=[17])
    """Its number."""
    at: Moment = Field(examples=["2026-11-21T10:00:00Z"])
    """Time of the request."""
    caller: str = Field(examples=["line 1 MES"])
    """Name of the caller; empty if unknown."""
    role: str = Field(examples=["mes"])
    """Role of the caller; empty if unknown."""
    key: str = Field(examples=["1f0c55a2"])
    """Id of the key; empty if none was needed."""
    address: str = Field(examples=["192.0.2.7"])
    """IP address of the client."""
    method: str = Field(examples=["POST"])
    """HTTP method."""
    path: str = Field(examples=["/api/v1/jobs/kit-17/abort"])
    """Path of the request."""
    operation: str = Field(examples=["abort_job"])
    """Operation id; empty if the request was refused earlier."""
    status: int = Field(examples=[200])
    """HTTP status of the response."""
    request: str = Field(examples=["9f3a5c0e1b2d4f66"])
    """Id of the request, as in the server's log."""
    job: str = Field(examples=["kit-17"])
    """Id of the job; empty if it was not about one."""
    comment: str = Field(examples=["wrong kit"])
    """Comment by the caller."""
    count: int = Field(default=1, examples=[1])
    """Number of requests: further refusals of the caller within a minute are counted; the last is shown."""
    previous: str = Field(default="", examples=["9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"])
    """SHA-256 of the record before, as exported; empty for the first one."""


AuditPage = Page[AuditRecord]
"""Some entries of the audit log, newest first."""


class Health(Answer):
    """Whether the server is alive."""

    alive: bool = Field(examples=[True])
    """Whether the control cycle runs."""
    why: str = ""
    """The fault; empty if there is none."""


class Readiness(Answer):
    """Whether the server can accept orders."""

    ready: bool = Field(examples=[True])
    """Whether the station is open and orders can be stored."""
    halted: bool = False
    """Whether everything is halted: orders are stored and wait."""
    why: str = ""
    """The fault; empty if there is none."""


class BackupOrder(Request):
    """A request for a copy of the data directory."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$", examples=["monday"])
    """Name of the copy."""


class Backup(Answer):
    """A copy of the data directory."""

    folder: str = Field(examples=["/srv/plant/backups/monday"])
    """Its path on the machine of the server."""
    files: list[str] = Field(examples=[["journal.db", "jobs.db"]])
    """Its files."""
    bytes: int = Field(examples=[184320])
    """Size of all together [bytes]."""


class DataFinding(Answer):
    """Something that is wrong with a file of the data directory."""

    file: str = Field(examples=["jobs.db"])
    """Its path in the data directory."""
    fault: str = Field(examples=["2 notes of commits are damaged"])
    """What is wrong."""
    advice: str = Field(examples=["restore a backup of the data directory"])
    """What to do."""


DataFindings = Page[DataFinding]
"""What is wrong with the data directory; nothing if every file is whole."""


SERVER_FILE = "server.json"
"""Name of the file in the data directory while a server uses it; readable only by its user."""


class LocalServer(BaseModel):
    """A server that runs on a data directory of this machine.

    Attributes:
        url: Its address.
        pid: Its process.
        token: A key of an administrator that counts until it ends.
    """

    model_config = ConfigDict(frozen=True)

    url: str = Field(examples=["http://127.0.0.1:8000"])
    """Its address."""
    pid: int = Field(examples=[4711])
    """Its process id."""
    token: str = Field(repr=False)
    """A key with the role admin, valid until the server ends."""


def is_address(text: str) -> bool:
    """Returns whether a text is an IP address."""
    try:
        ipaddress.ip_address(text)
    except ValueError:
        return False
    return True


def is_loopback(host: str) -> bool:
    """Returns whether an address can be reached only by programs on this machine."""
    return host == "localhost" or (is_address(host) and ipaddress.ip_address(host).is_loopback)
