"""How programs of the same user find the server of a data directory."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

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
