"""Routes: keys, the caller's own session, and the audit log."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from fastapi import APIRouter, Path, Query, Request, Response

from skiros_py.api.server import ApiKey, AuditPage, KeyOrder, Login, Me, NewKey
from skiros_py.server.access.authenticator import LIFETIME, cookie_name
from skiros_py.server.access.keys import shown
from skiros_py.server.access.openapi import operations
from skiros_py.server.access.roles import Caller, CallerDep, Role, needs
from skiros_py.server.services import Services, ServicesDep
from skiros_py.server.settings import is_loopback
from skiros_py.station.requests import addressed

router = APIRouter(prefix="/audit", tags=["access"])

Limit = Annotated[int, Query(ge=1, le=1000)]
Cursor = Annotated[str | None, Query(pattern="^[0-9]{1,18}$")]


@router.get("", dependencies=[needs(Role.ADMIN)])
def list_audit(services: ServicesDep, limit: Limit = 100, cursor: Cursor = None) -> AuditPage:
    """List the audit log.

    Lists requests that changed something or were refused, newest first. The last 100,000 are kept.

    Keys and bodies are never recorded. At most 30 refusals per minute are recorded for one address.
    """
    entries = services.audit.page(int(cursor) if cursor is not None else None, limit)
    return AuditPage(items=entries, next=str(entries[-1].number) if len(entries) == limit else None)


keys_router = APIRouter(prefix="/keys", tags=["access"])

KeyId = Annotated[str, Path(max_length=64, description="Id of the key.", examples=["1f0c55a2"])]


@keys_router.get("", dependencies=[needs(Role.ADMIN)])
def list_keys(services: ServicesDep) -> list[ApiKey]:
    """List keys.

    Lists all keys, including revoked and expired ones; their secrets are not stored.
    """
    return [shown(key) for key in services.keys.all()]


@keys_router.post("", status_code=201, dependencies=[needs(Role.ADMIN)])
def create_key(order: KeyOrder, services: ServicesDep, response: Response) -> NewKey:
    """Create a key.

    Creates a key. The secret is returned only in this response. Once the first key exists, every caller needs one.
    """
    expires = order.expires.timestamp() if order.expires is not None else None
    key, text = services.keys.create(order.name, Role(order.role), expires)
    response.headers["Location"] = f"/api/v1/keys/{key.id}"
    return NewKey(key=shown(key), secret=text)


@keys_router.get("/{key_id}", dependencies=[needs(Role.ADMIN)])
def get_key(key_id: KeyId, services: ServicesDep) -> ApiKey:
    """Get a key.

    Returns a key.
    """
    with addressed("UnknownKey"):
        return shown(services.keys.key(key_id))


@keys_router.delete("/{key_id}", dependencies=[needs(Role.ADMIN)])
def revoke_key(key_id: KeyId, services: ServicesDep) -> ApiKey:
    """Revoke a key.

    Revokes a key immediately and permanently; its sessions and streams end. Repeating the request has no effect.

    If other machines can reach the server, the last admin key cannot be revoked.
    """
    with addressed("UnknownKey"):
        return shown(services.keys.revoke(key_id, open_to_others=not is_loopback(services.settings.host)))


class _CookieOptions(TypedDict):
    httponly: bool
    samesite: Literal["strict"]
    secure: bool


session_router = APIRouter(prefix="/session", tags=["access"])


@session_router.get("", dependencies=[needs(Role.VIEWER, mes=True)])
def get_session(request: Request, services: ServicesDep, caller: CallerDep) -> Me:
    """Get the caller's identity.

    Returns who the caller is and which operations they may use, so that a page offers only these.

    Responds with 401 if a key is needed and none was sent.
    """
    return _me(request, services, caller)


@session_router.post("")
async def login(login: Login, request: Request, services: ServicesDep, response: Response) -> Me:
    """Log in.

    Exchanges a key for a cookie, for web pages; it is valid for 12 hours, or until the key is revoked.
    """
    address = request.client.host if request.client is not None else ""
    key, text = services.authenticator.login(login.key, address)
    request.state.caller = Caller(key.name, key.role, key.id)
    response.set_cookie(_cookie(request), text, max_age=LIFETIME, **_options(request))
    return _me(request, services, request.state.caller)


@session_router.delete("", status_code=204, dependencies=[needs(Role.VIEWER, mes=True)])
async def logout(request: Request, services: ServicesDep) -> Response:
    """Log out.

    Ends the session of the cookie. Repeating the request has no effect.
    """
    services.authenticator.logout(request.headers)
    response = Response(status_code=204)
    response.delete_cookie(_cookie(request), **_options(request))
    return response


def _cookie(request: Request) -> str:
    return cookie_name(request.headers.get("host", ""))


def _options(request: Request) -> _CookieOptions:
    return {"httponly": True, "samesite": "strict", "secure": request.url.scheme == "https"}


def _me(request: Request, services: Services, caller: Caller) -> Me:
    allowed = [
        operation
        for operation, asked in operations(request.app).items()
        if all(need.allows(caller.role) for need in asked)
    ]
    return Me.model_validate(
        {
            "name": caller.name,
            "role": caller.role.value,
            "key": caller.key,
            "keys_needed": services.authenticator.keys_needed,
            "operations": sorted(allowed),
        }
    )
