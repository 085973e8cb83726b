"""Which pages in browsers may use this server."""

from __future__ import annotations

import re
from urllib.parse import urlsplit

from starlette.datastructures import Headers

from skiros_py.api.server import is_address
from skiros_py.server.problems import Problem
from skiros_py.server.settings import ServerSettings

SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
"""Methods that change nothing."""

_HOST = re.compile(r"(\[[0-9a-fA-F:.]+\]|[A-Za-z0-9_.-]+)(?::\d{1,5})?")
_METHODS = "GET, HEAD, POST, PUT, PATCH, DELETE"
_TAKEN = "Authorization, X-API-Key, Content-Type, If-Match, Idempotency-Key, Prefer, Last-Event-ID, X-Request-Id"
_TOLD = "ETag, Location, Retry-After, X-Request-Id"


class OriginPolicy:
    """Checks the headers in which browsers name the page behind a request; other programs may send anything.

    Args:
        settings: Settings of the server.
    """

    def __init__(self, settings: ServerSettings) -> None:
        bound = settings.host.strip("[]").lower()
        self._any_address = bound in {"0.0.0.0", "::", ""}  # noqa: S104 - compared, not bound
        names = {"127.0.0.1", "localhost", "::1", bound, *(name.lower() for name in settings.allowed_hosts)}
        self._public = settings.public_origin
        if self._public:
            names.add(urlsplit(self._public).hostname or "")
        self._names = frozenset(name.strip("[]") for name in names)
        self._origins = frozenset(origin.rstrip("/").lower() for origin in settings.allowed_origins)

    def check_host(self, headers: Headers) -> None:
        """Checks that the Host header names this server: a foreign page can have its own name resolve to it.

        Raises:
            Problem: It does not.
        """
        match = _HOST.fullmatch(", ".join(headers.getlist("host")))  # two of them are not a valid name
        name = match[1].strip("[]").lower() if match else ""
        # An IP address cannot be made to resolve elsewhere, so any is accepted if the server listens on all of them.
        if name not in self._names and not (self._any_address and is_address(name)):
            raise Problem(
                403,
                "HostRefused",
                f"this server is not called {headers.get('host', '')[:100]!a}: start it with --allow-host where it is",
            )

    def check_origin(self, method: str, scheme: str, headers: Headers) -> None:
        """Checks that a request that changes something does not come from a foreign page in a user's browser.

        Raises:
            Problem: It does.
        """
        if method in SAFE or self.allowed(headers):
            return
        origin = headers.get("origin")
        own = (f"{scheme}://{headers.get('host', '')}".lower(), self._public)
        foreign = origin is not None and origin.lower() not in own
        if foreign or headers.get("sec-fetch-site") == "cross-site":
            raise Problem(
                403,
                "OriginRefused",
                f"pages of {(origin or 'another site')[:200]!a} may not change anything here: start the server with"
                " --allow-origin to let them",
            )

    def allowed(self, headers: Headers) -> str | None:
        """Returns the origin of a foreign page that may use this server; None if there is none."""
        origin = headers.get("origin", "")
        return origin if origin.lower() in self._origins else None

    def answer(self, headers: Headers) -> dict[str, str]:
        """Returns the CORS headers for a page that may use this server; none for others."""
        origin = self.allowed(headers)
        if origin is None:
            return {}
        return {"Access-Control-Allow-Origin": origin, "Vary": "Origin", "Access-Control-Expose-Headers": _TOLD}

    def preflight(self, headers: Headers) -> dict[str, str]:
        """Returns the headers of the answer to a preflight request.

        Raises:
            Problem: The page may not use this server.
        """
        if self.allowed(headers) is None:
            raise Problem(403, "OriginRefused", "pages of that origin may not use this server")
        more = {"Access-Control-Allow-Methods": _METHODS, "Access-Control-Allow-Headers": _TAKEN}
        return {**self.answer(headers), **more, "Access-Control-Max-Age": "600"}
