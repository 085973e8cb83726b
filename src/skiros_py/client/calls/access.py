"""Access: keys, the caller's own session, the audit log."""

from __future__ import annotations

from skiros_py.api.server import ApiKey, AuditPage, KeyOrder, Login, Me, NewKey
from skiros_py.client.request import Call, nothing, path_of


def list_audit(limit: int = 100, cursor: str | None = None) -> Call[AuditPage]:
    """Lists requests that changed something or were refused, newest first."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/audit", AuditPage, query=query)


def list_keys() -> Call[list[ApiKey]]:
    """Lists the keys, revoked ones too."""
    return Call("GET", "/keys", list[ApiKey])


def create_key(order: KeyOrder) -> Call[NewKey]:
    """Creates a key; its secret is shown only this once."""
    body = order.model_dump(mode="json", exclude_none=True)
    return Call("POST", "/keys", NewKey, json=body, repeatable=False)


def get_key(key: str) -> Call[ApiKey]:
    """Returns a key by its id."""
    return Call("GET", path_of("keys", key), ApiKey)


def revoke_key(key: str) -> Call[ApiKey]:
    """Revokes a key by its id."""
    return Call("DELETE", path_of("keys", key), ApiKey)


def get_session() -> Call[Me]:
    """Returns who the caller is and what they may do."""
    return Call("GET", "/session", Me)


def login(key: str) -> Call[Me]:
    """Starts a login session, as web pages do; not needed by programs, which send their key with each request."""
    return Call("POST", "/session", Me, json=Login(key=key).model_dump())


def logout() -> Call[None]:
    """Ends the session."""
    return Call("DELETE", "/session", nothing)
