"""The caller's own session: who they are, what they may do; logins of web pages."""

from __future__ import annotations

from typing import Literal, TypedDict

from fastapi import APIRouter, Request, Response

from skiros_py.api.access import Login, Me
from skiros_py.server.access.authenticator import LIFETIME, cookie_name
from skiros_py.server.access.openapi import operations
from skiros_py.server.access.roles import Caller, CallerDep, Role, needs
from skiros_py.server.services import Services, ServicesDep


class _CookieOptions(TypedDict):
    httponly: bool
    samesite: Literal["strict"]
    secure: bool


router = APIRouter(prefix="/session", tags=["access"])


@router.get("", summary="Who am I?", dependencies=[needs(Role.VIEWER, mes=True)])
def get_session(request: Request, services: ServicesDep, caller: CallerDep) -> Me:
    """Returns who the caller is and what they may do, so that a page offers nothing that would be refused.

    Answered with 401 where a key is needed and none was shown.
    """
    return _me(request, services, caller)


@router.post("", summary="Log in")
async def login(login: Login, request: Request, services: ServicesDep, response: Response) -> Me:
    """Takes a key, and gives a cookie for it, for pages in a browser; for 12 hours, or until the key is revoked."""
    address = request.client.host if request.client is not None else ""
    key, text = services.authenticator.login(login.key, address)
    request.state.caller = Caller(key.name, key.role, key.id)
    response.set_cookie(_cookie(request), text, max_age=LIFETIME, **_options(request))
    return _me(request, services, request.state.caller)


@router.delete("", status_code=204, summary="Log out", dependencies=[needs(Role.VIEWER, mes=True)])
async def logout(request: Request, services: ServicesDep) -> Response:
    """Ends the login that the cookie stands for. Once more does no harm."""
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
