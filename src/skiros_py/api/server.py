"""The server itself: keys, the caller's session, the audit log, its health, and how local programs find it."""

from __future__ import annotations

import ipaddress
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from skiros_py.api.wire import Answer, Moment, Page, Request, WantedMoment

RoleName = Literal["viewer", "operator", "engineer", "admin", "mes"]
"""What somebody may do. Each of the first four may do what those before it may; mes may order and command jobs."""


class KeyOrder(Request):
    """A wish for a key."""

    name: str = Field(min_length=1, max_length=100, examples=["line 1 MES"])
    """Who gets it; author of what they write."""
    role: RoleName = Field(examples=["mes"])
    """What they may do."""
    expires: WantedMoment | None = Field(default=None, examples=["2030-01-01T00:00:00Z"])
    """From when on it is not valid any more; never where left out."""


class ApiKey(Answer):
    """A key, without what is secret about it."""

    id: str = Field(examples=["1f0c55a2"])
    """Names it."""
    name: str = Field(examples=["line 1 MES"])
    """Its owner."""
    role: RoleName = Field(examples=["mes"])
    """What they may do."""
    shown: str = Field(examples=["sk_1f0c55a2_…Zw4k"])
    """Its beginning and its end, to tell keys apart."""
    created: Moment = Field(examples=["2026-11-21T10:00:00Z"])
    """When it was made."""
    expires: Moment | None = None
    """From when on it is not valid; null for never."""
    revoked: Moment | None = None
    """When it was revoked; null while it is not."""
    used: Moment | None = None
    """When it was last used, about; null before that."""
    valid: bool = Field(examples=[True])
    """True while it opens the door."""


class NewKey(Answer):
    """A key that was just made."""

    key: ApiKey
    """What is known of it from now on."""
    secret: str = Field(examples=["sk_1f0c55a2_…"], repr=False)
    """The key itself. It is shown this once, and kept nowhere."""


class Login(Request):
    """A key, shown once by a web page, which gets a cookie for it."""

    key: str = Field(min_length=1, max_length=200, examples=["sk_1f0c55a2_…"], repr=False)
    """The key."""


class Me(Answer):
    """Who the caller is."""

    name: str = Field(examples=["anna"])
    """Their name; author of what they write."""
    role: RoleName = Field(examples=["operator"])
    """What they may do, in one word."""
    key: str = Field(examples=["1f0c55a2"])
    """Id of their key; empty where none is needed."""
    keys_needed: bool = Field(examples=[True])
    """True if every request needs a key."""
    operations: list[str] = Field(examples=[["list_jobs"]])
    """What they may do, as operation ids of the API's description."""


class AuditRecord(Answer):
    """One request that changed something, or was refused."""

    number: int = Field(examples=[17])
    """Counts them."""
    at: Moment = Field(examples=["2026-11-21T10:00:00Z"])
    """When."""
    caller: str = Field(examples=["line 1 MES"])
    """Name of who made it; empty for strangers."""
    role: str = Field(examples=["mes"])
    """Their role; empty for strangers."""
    key: str = Field(examples=["1f0c55a2"])
    """Id of their key; empty where none was needed."""
    address: str = Field(examples=["192.0.2.7"])
    """The address it came from."""
    method: str = Field(examples=["POST"])
    """HTTP method."""
    path: str = Field(examples=["/api/v1/jobs/kit-17/abort"])
    """What it was about."""
    operation: str = Field(examples=["abort_job"])
    """Which operation; empty where it did not get so far."""
    status: int = Field(examples=[200])
    """HTTP status of the answer."""
    request: str = Field(examples=["9f3a5c0e1b2d4f66"])
    """Id of the request; the server's log has the same."""
    job: str = Field(examples=["kit-17"])
    """Id of the job that it was about; empty where none."""
    comment: str = Field(examples=["wrong kit"])
    """What the caller said about it."""


AuditPage = Page[AuditRecord]
"""Some of the audit log, the youngest entry first."""


class Health(Answer):
    """Whether the server is alive."""

    alive: bool = Field(examples=[True])
    """True while the control cycle goes round."""
    why: str = ""
    """What is wrong; empty in good times."""


class Readiness(Answer):
    """Whether orders can be fulfilled."""

    ready: bool = Field(examples=[True])
    """True while the station is open and what is ordered can be kept."""
    halted: bool = False
    """True while everything is halted: orders are kept and wait."""
    why: str = ""
    """What is wrong; empty in good times."""


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

    url: str = Field(examples=["http://127.0.0.1:8000"])
    """Its address."""
    pid: int = Field(examples=[4711])
    """Its process."""
    token: str = Field(repr=False)
    """A key of an administrator that counts until it ends."""


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
