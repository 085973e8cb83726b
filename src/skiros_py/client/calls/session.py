"""The caller's own session: who they are, what they may do."""

from __future__ import annotations

from skiros_py.api.session import Login, Me
from skiros_py.client.call import Call, nothing


def get_session() -> Call[Me]:
    """Tells who the caller is and what they may do."""
    return Call("GET", "/session", Me)


def login(key: str) -> Call[Me]:
    """Logs in as web pages do; programs need not, they show their key with each request."""
    return Call("POST", "/session", Me, json=Login(key=key).model_dump())


def logout() -> Call[None]:
    """Ends such a login."""
    return Call("DELETE", "/session", nothing)
