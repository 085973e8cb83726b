"""Logins on the wire: who somebody is to the server, and what they may do."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.keys import RoleName
from skiros_py.api.wire import Answer, Request


class Login(Request):
    """A key, shown once by a web page, which gets a cookie for it."""

    key: str = Field(min_length=1, max_length=200, description="The key.", examples=["sk_1f0c55a2_…"], repr=False)


class Me(Answer):
    """Who the caller is."""

    name: str = Field(description="Their name; author of what they write.", examples=["anna"])
    role: RoleName = Field(description="What they may do, in one word.", examples=["operator"])
    key: str = Field(description="Id of their key; empty where none is needed.", examples=["1f0c55a2"])
    keys_needed: bool = Field(description="True where nobody comes in without a key.", examples=[True])
    operations: list[str] = Field(
        description="What they may do, as operation ids of the API's description.", examples=[["list_jobs"]]
    )
