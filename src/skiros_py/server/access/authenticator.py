"""Identifies the caller of a request by the key or login that the request carries."""

from __future__ import annotations

import re
import secrets
import time
from collections import OrderedDict

from starlette.datastructures import Headers
from starlette.requests import cookie_parser

from skiros_py.errors import UsageError
from skiros_py.server.access.keys import Key, KeyStore, digest
from skiros_py.server.access.limiters import Rates, network_of
from skiros_py.server.access.roles import LOCAL, Caller, Role
from skiros_py.server.problems import Problem
from skiros_py.server.settings import ServerSettings

_GUESSES = 10
"""Number of wrong keys accepted from one address per minute."""
_LONGEST_USER = 100
_REALM = {"WWW-Authenticate": 'Bearer realm="skiros"'}


def check_access(settings: ServerSettings, keys: KeyStore) -> None:
    """Checks that the server cannot be reached from other machines without a key.

    Args:
        settings: Settings of the server.
        keys: The API keys.

    Raises:
        UsageError: Other machines can reach the server, and there is no key.
    """
    if not settings.is_local and not any(key.valid for key in keys.all()):
        raise UsageError(
            f"other machines can reach {settings.reached_at}, and there is no key yet: make one with"
            " 'skiros key create NAME --role admin --data DIR' (and --new where that is not there yet), or listen at"
            " 127.0.0.1"
        )


class Authenticator:
    """Identifies the caller of a request. To be used in the thread of the event loop only.

    Args:
        settings: Settings of the server.
        keys: The API keys.

    Attributes:
        keys: The API keys.
        logins: Logins from web pages.
    """

    def __init__(self, settings: ServerSettings, keys: KeyStore) -> None:
        self.keys = keys
        self.logins = Logins()
        self._settings = settings
        self._is_local = settings.is_local
        self._guesses = Rates(_GUESSES, 60.0)

    @property
    def keys_needed(self) -> bool:
        """True while every request needs a key."""
        wanted = self._settings.authentication
        if wanted == "auto":
            return not self._is_local or self.keys.needed
        return wanted == "keys"

    def caller(self, headers: Headers, address: str) -> Caller:
        """Identifies the caller of a request. A key in the request must be valid even if none is needed.

        Args:
            headers: The request's headers.
            address: Address from which the request comes.

        Raises:
            Problem: There is no key (401), the key is wrong (401), or there were too many wrong keys (429).
        """
        shown = _shown(headers)
        if shown is not None:
            return self._by_key(shown, headers, address)
        key = self._logged_in(headers)
        if key is not None:
            return Caller(key.name, key.role, key.id)
        if self.keys_needed:
            raise _stranger("a key is needed: send it as 'Authorization: Bearer sk_…', or as X-API-Key")
        return Caller(_user(headers), Role.ADMIN)

    def login(self, text: str, address: str) -> tuple[Key, str]:
        """Logs the owner of a key in from a web page.

        Args:
            text: The key.
            address: Address from which the request comes.

        Returns:
            The key, and the text of the cookie.

        Raises:
            Problem: The key is wrong (401), or there were too many wrong keys (429).
        """
        key = self.keys.check(text)
        if key is None:
            raise self._wrong(address)
        return key, self.logins.begin(key.id)

    def logout(self, headers: Headers) -> None:
        """Ends the login that the request carries, if any."""
        text = _cookie(headers)
        if text is not None:
            self.logins.end(text)

    def recheck(self, caller: Caller) -> bool:
        """Returns whether a caller's key is still valid; for streams."""
        if not caller.key:
            return not self.keys_needed
        return caller.key == LOCAL or self.keys.recheck(caller.key) is not None

    def _by_key(self, shown: str, headers: Headers, address: str) -> Caller:
        # A correct key passes regardless of the number of wrong keys from the same address: a caller cannot lock out
        # others who share its address, and a key of 256 random bits cannot be guessed at any rate.
        key = self.keys.check(shown)
        if key is not None:
            return Caller(key.name, key.role, key.id)
        if self.keys.is_local(shown):
            return Caller(_user(headers), Role.ADMIN, LOCAL)
        raise self._wrong(address)

    def _wrong(self, address: str) -> Problem:
        who = network_of(address)
        if self._guesses.take(who):
            return _stranger("that is no valid key: it is mistyped, revoked or has expired")
        wait = {"Retry-After": f"{self._guesses.wait(who) + 1:.0f}"}
        return Problem(429, "TooManyGuesses", "too many wrong keys came from this address", headers=wait)

    def _logged_in(self, headers: Headers) -> Key | None:
        text = _cookie(headers)
        key = self.logins.key(text) if text is not None else None
        return self.keys.recheck(key) if key is not None else None


def _shown(headers: Headers) -> str | None:
    """Returns the key in the headers; None if there is none, an invalid key if it cannot be parsed."""
    authorization = headers.get("authorization")
    if authorization is None:
        return headers.get("x-api-key")
    scheme, _, text = authorization.partition(" ")
    return text.strip() if scheme.lower() == "bearer" else ""


def _cookie(headers: Headers) -> str | None:
    return cookie_parser(headers.get("cookie", "")).get(cookie_name(headers.get("host", "")))


def _user(headers: Headers) -> str:
    """Returns the name that a caller without a key gives; used for authorship only."""
    given = headers.get("x-skiros-user", "").encode("latin-1").decode("utf-8", "replace")
    return "".join(c for c in given if c.isprintable())[:_LONGEST_USER].strip() or LOCAL


def _stranger(detail: str) -> Problem:
    return Problem(401, "KeyNeeded", detail, headers=_REALM)


COOKIE = "skiros_session"
"""Name of the cookie if the address has no port."""
LIFETIME = 12 * 3600
"""Lifetime of a login [s]."""
_MOST = 1000
"""Number of logins kept; one more replaces the oldest."""


def cookie_name(host: str) -> str:
    """Returns the name of the cookie: browsers send a cookie to all ports of a host, and each may be another server.

    Args:
        host: The Host header, which is the address as the browser sees it.
    """
    port = re.search(r":(\d{1,5})$", host)
    return f"{COOKIE}_{port[1]}" if port else COOKIE


class Logins:
    """The active logins; in memory only, so that a restart of the server ends every login. Thread-safe."""

    def __init__(self) -> None:
        self._logins: OrderedDict[bytes, tuple[str, float]] = OrderedDict()

    def begin(self, key: str) -> str:
        """Logs in the owner of a key, and returns the text of the cookie."""
        text = secrets.token_urlsafe(32)
        self._logins[digest(text)] = (key, time.monotonic() + LIFETIME)
        while len(self._logins) > _MOST:
            self._logins.popitem(last=False)
        return text

    def key(self, text: str) -> str | None:
        """Returns the id of the key to which a cookie belongs; None if the login has ended or never existed."""
        # The lookup by digest takes the same time for every guess.
        key, until = self._logins.get(digest(text), ("", 0.0))
        return key if time.monotonic() < until else None

    def end(self, text: str) -> None:
        """Logs out; may be called again."""
        self._logins.pop(digest(text), None)
