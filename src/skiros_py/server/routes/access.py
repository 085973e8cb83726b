"""Routes: keys, the caller's own session, and the audit log."""

from __future__ import annotations

from typing import Annotated, Any
from urllib.parse import urlsplit

from fastapi import Path, Query, Request, Response
from fastapi.responses import StreamingResponse

from skiros_py.api.server import ApiKey, ApiKeys, AuditPage, KeyOrder, Login, Me, NewKey
from skiros_py.server.access.authenticator import LIFETIME, cookie_name
from skiros_py.server.access.keys import shown
from skiros_py.server.access.openapi import operations
from skiros_py.server.access.roles import Act, Admin, Anybody, Caller, Role, ViewerOrMes
from skiros_py.server.problems import topic_router

router = topic_router("access", "/audit")

Limit = Annotated[int, Query(ge=1, le=1000)]
Cursor = Annotated[str | None, Query(pattern="^[0-9]{1,18}$")]


@router.get("")
def list_audit(act: Admin, limit: Limit = 100, cursor: Cursor = None) -> AuditPage:
    """List the audit log.

    Lists requests that changed something or were refused, newest first. The last 100,000 are kept.

    Keys and bodies are never recorded. After the first five refusals of a caller in a minute, further ones are counted
    in one record.
    """
    return act.services.audit.page(int(cursor) if cursor is not None else None, limit)


@router.get(
    "/export",
    response_class=StreamingResponse,
    responses={200: {"content": {"application/jsonl": {"schema": {"type": "string"}}}}},
)
def export_audit(act: Admin) -> StreamingResponse:
    """Export the audit log.

    Returns all records as JSON Lines, oldest first. Each line holds the SHA-256 of the line before as `previous`.
    """
    lines = (f"{line}\n" for line in act.services.audit.lines())
    return StreamingResponse(lines, media_type="application/jsonl")


keys_router = topic_router("access", "/keys")

KeyId = Annotated[str, Path(max_length=64, description="Id of the key.", examples=["1f0c55a2"])]


@keys_router.get("")
def list_keys(act: Admin) -> ApiKeys:
    """List keys.

    Lists all keys, including revoked and expired ones; their secrets are not stored.
    """
    return ApiKeys(items=[shown(key) for key in act.services.keys.all()])


@keys_router.post("", status_code=201)
def create_key(act: Admin, order: KeyOrder) -> NewKey:
    """Create a key.

    Creates a key. The secret is returned only in this response. Once the first key exists, every caller needs one.
    """
    expires = order.expires.timestamp() if order.expires is not None else None
    key, text = act.services.keys.create(order.name, Role(order.role), expires)
    act.locate("keys", key.id)
    return NewKey(key=shown(key), secret=text)


@keys_router.get("/{key_id}")
def get_key(act: Admin, key_id: KeyId) -> ApiKey:
    """Get a key.

    Returns a key.
    """
    return shown(act.services.keys.key(key_id))


@keys_router.delete("/{key_id}")
def revoke_key(act: Admin, key_id: KeyId) -> ApiKey:
    """Revoke a key.

    Revokes a key immediately and permanently; its sessions and streams end. Repeating the request has no effect.

    If other machines can reach the server, the last admin key cannot be revoked.
    """
    return shown(act.services.keys.revoke(key_id, open_to_others=not act.services.settings.is_local))


session_router = topic_router("access", "/session")


@session_router.get("")
def get_session(act: ViewerOrMes) -> Me:
    """Get the caller's identity.

    Returns who the caller is and which operations they may use, so that a page offers only these.

    Responds with 401 if a key is needed and none was sent.
    """
    return _me(act)


@session_router.post("")
async def login(act: Anybody, login: Login) -> Me:
    """Log in.

    Exchanges a key for a cookie, for web pages; it is valid for 12 hours, or until the key is revoked.
    """
    request = act.request
    address = request.client.host if request.client is not None else ""
    key, text = act.services.authenticator.login(login.key, address)
    request.state.caller = Caller(key.name, key.role, key.id)
    act.response.set_cookie(_cookie(request), text, max_age=LIFETIME, **_options(act))
    return _me(act)


@session_router.delete("", status_code=204)
async def logout(act: ViewerOrMes) -> Response:
    """Log out.

    Ends the session of the cookie. Repeating the request has no effect.
    """
    act.services.authenticator.logout(act.request.headers)
    response = Response(status_code=204)
    response.delete_cookie(_cookie(act.request), **_options(act))
    return response


def _cookie(request: Request) -> str:
    return cookie_name(request.headers.get("host", ""))


def _options(act: Act) -> dict[str, Any]:
    settings = act.services.settings
    secure = "https" in (act.request.url.scheme, urlsplit(settings.public_url).scheme)
    return {"httponly": True, "samesite": "strict", "secure": secure, "path": settings.prefix or "/"}


def _me(act: Act) -> Me:
    caller = act.caller
    asked = operations(act.request.app).items()
    return Me(
        name=caller.name,
        role=caller.role.value,
        key=caller.key,
        keys_needed=act.services.authenticator.keys_needed,
        operations=sorted(name for name, needs in asked if all(need.allows(caller.role) for need in needs)),
    )
