"""Keys on the wire: who may come in, as what."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

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
