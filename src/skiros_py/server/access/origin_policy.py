"""Where a request comes from, as browsers tell it: the names we are called by, and the pages that may use us."""

from __future__ import annotations

import ipaddress
import re

from starlette.datastructures import Headers

from skiros_py.server.problems import Problem
from skiros_py.server.settings import ServerSettings

SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
"""Methods that change nothing."""

_HOST = re.compile(r"(\[[0-9a-fA-F:.]+\]|[A-Za-z0-9_.-]+)(?::\d{1,5})?")
_METHODS = "GET, HEAD, POST, PUT, PATCH, DELETE"
_TAKEN = "Authorization, X-API-Key, Content-Type, If-Match, Idempotency-Key, Prefer, Last-Event-ID, X-Request-Id"
_TOLD = "ETag, Location, Retry-After, X-Request-Id"


class OriginPolicy:
    """Checks what browsers say about the page that makes a request; other programs say nothing, or what they like.

    Args:
        settings: How the server is set up.
    """

    def __init__(self, settings: ServerSettings) -> None:
        bound = settings.host.strip("[]").lower()
        self._any_address = bound in {"0.0.0.0", "::", ""}  # noqa: S104 - compared, not bound
        names = {"127.0.0.1", "localhost", "::1", bound, *(name.lower() for name in settings.allowed_hosts)}
        self._names = frozenset(name.strip("[]") for name in names)
        self._origins = frozenset(origin.rstrip("/").lower() for origin in settings.allowed_origins)

    def check_host(self, headers: Headers) -> None:
        """Checks that we are called by a name of ours: a page of somebody else can have its own name lead to us.

        Raises:
            Problem: We are not.
        """
        match = _HOST.fullmatch(", ".join(headers.getlist("host")))  # two of them are no name at all
        name = match[1].strip("[]").lower() if match else ""
        # An address cannot be made to lead elsewhere, so where we listen at all of them any will do.
        if name not in self._names and not (self._any_address and _is_address(name)):
            raise Problem(
                403,
                "HostRefused",
                f"this server is not called {headers.get('host', '')[:100]!a}: start it with --allow-host where it is",
            )

    def check_origin(self, method: str, scheme: str, headers: Headers) -> None:
        """Checks that no page of somebody else has its visitor's browser change anything here.

        Raises:
            Problem: One does.
        """
        if method in SAFE or self.allowed(headers):
            return
        origin = headers.get("origin")
        foreign = origin is not None and origin.lower() != f"{scheme}://{headers.get('host', '')}".lower()
        if foreign or headers.get("sec-fetch-site") == "cross-site":
            raise Problem(
                403,
                "OriginRefused",
                f"pages of {(origin or 'another site')[:200]!a} may not change anything here: start the server with"
                " --allow-origin to let them",
            )

    def allowed(self, headers: Headers) -> str | None:
        """Returns the origin of a page of somebody else that may use us; None where there is none such."""
        origin = headers.get("origin", "")
        return origin if origin.lower() in self._origins else None

    def answer(self, headers: Headers) -> dict[str, str]:
        """Returns what an answer says to the browser of a page that may use us; nothing for others."""
        origin = self.allowed(headers)
        if origin is None:
            return {}
        return {"Access-Control-Allow-Origin": origin, "Vary": "Origin", "Access-Control-Expose-Headers": _TOLD}

    def preflight(self, headers: Headers) -> dict[str, str]:
        """Returns what is said to a browser that asks whether a page may use us.

        Raises:
            Problem: It may not.
        """
        if self.allowed(headers) is None:
            raise Problem(403, "OriginRefused", "pages of that origin may not use this server")
        more = {"Access-Control-Allow-Methods": _METHODS, "Access-Control-Allow-Headers": _TAKEN}
        return {**self.answer(headers), **more, "Access-Control-Max-Age": "600"}


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
