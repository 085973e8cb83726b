"""Who makes a request: found from the key they show, or the login that stands for one."""

from __future__ import annotations

import hashlib
import re
import secrets
import time
from collections import OrderedDict
from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers

from skiros_py.errors import UsageError
from skiros_py.server.access.keys import Key, KeyStore
from skiros_py.server.access.limits import Rates, network_of
from skiros_py.server.access.roles import LOCAL, Caller, Role
from skiros_py.server.problems import Problem
from skiros_py.server.settings import ServerSettings, is_loopback

_GUESSES = 10
"""Wrong keys that one address may show in a minute."""
_LONGEST_USER = 100
_REALM = {"WWW-Authenticate": 'Bearer realm="skiros"'}


def check_access(settings: ServerSettings, keys: KeyStore) -> None:
    """Checks that nobody from outside can come in without a key.

    Args:
        settings: How the server is set up.
        keys: The keys there are.

    Raises:
        UsageError: Other machines could reach the server, and there is no key to come in with.
    """
    if not is_loopback(settings.host) and not any(key.valid for key in keys.all()):
        raise UsageError(
            f"other machines reach {settings.host}, and nobody has a key: make one with"
            " 'skiros key create NAME --role admin --data DIR' (and --new where that is not there yet), or listen at"
            " 127.0.0.1"
        )


class Authenticator:
    """Finds the caller of a request. For the thread of the event loop.

    Args:
        settings: How the server is set up.
        keys: The keys there are.

    Attributes:
        keys: The keys there are.
        logins: Who is logged in from a web page.
    """

    def __init__(self, settings: ServerSettings, keys: KeyStore) -> None:
        self.keys = keys
        self.logins = Logins()
        self._settings = settings
        self._guesses = Rates(_GUESSES, 60.0)

    @property
    def keys_needed(self) -> bool:
        """True while every request needs a key."""
        wanted = self._settings.authentication
        if wanted == "auto":
            return not is_loopback(self._settings.host) or self.keys.needed
        return wanted == "keys"

    def caller(self, headers: Headers, address: str) -> Caller:
        """Finds out who makes a request. A key that is shown has to be right, also where none is needed.

        Args:
            headers: The request's headers.
            address: Where it comes from.

        Raises:
            Problem: There is no key (401), a wrong one (401), or there were many wrong ones (429).
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
            address: Where they come from.

        Returns:
            The key, and the text of the cookie.

        Raises:
            Problem: The key is wrong (401), or there were many wrong ones (429).
        """
        key = self.keys.check(text)
        if key is None:
            raise self._wrong(address)
        return key, self.logins.begin(key.id)

    def logout(self, headers: Headers) -> None:
        """Ends the login that a request shows, if there is one."""
        text = _cookie(headers)
        if text is not None:
            self.logins.end(text)

    def still(self, caller: Caller) -> bool:
        """Returns whether a caller may stay: their key was not revoked meanwhile; for streams."""
        if not caller.key:
            return not self.keys_needed
        return caller.key == LOCAL or self.keys.still(caller.key) is not None

    def _by_key(self, shown: str, headers: Headers, address: str) -> Caller:
        # A right key passes however many wrong ones came from the same address: nobody can lock their neighbours out,
        # and with 256 random bits a key cannot be guessed at any rate.
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
        return self.keys.still(key) if key is not None else None


def _shown(headers: Headers) -> str | None:
    """Returns the key that headers show; None for none, something wrong for what cannot be made out."""
    authorization = headers.get("authorization")
    if authorization is None:
        return headers.get("x-api-key")
    scheme, _, text = authorization.partition(" ")
    return text.strip() if scheme.lower() == "bearer" else ""


def _cookie(headers: Headers) -> str | None:
    given, name = headers.get("cookie", ""), cookie_name(headers.get("host", ""))
    if name not in given:
        return None
    try:
        morsel = SimpleCookie(given).get(name)
    except CookieError:
        return None
    return morsel.value if morsel is not None else None


def _user(headers: Headers) -> str:
    """Returns how somebody calls themselves who needs no key: for authorship only."""
    given = headers.get("x-skiros-user", "").encode("latin-1").decode("utf-8", "replace")
    return "".join(c for c in given if c.isprintable())[:_LONGEST_USER].strip() or LOCAL


def _stranger(detail: str) -> Problem:
    return Problem(401, "KeyNeeded", detail, headers=_REALM)


COOKIE = "skiros_session"
"""Name of the cookie, where the address has no port."""
LIFETIME = 12 * 3600
"""How long a login lasts [s]."""
_MOST = 1000
"""Logins that are kept; the oldest goes when there is one more."""


def cookie_name(host: str) -> str:
    """Returns the name of the cookie: browsers show a cookie to every port of a host, and each may be another server.

    Args:
        host: The address as the browser calls it: the Host header.
    """
    port = re.search(r":(\d{1,5})$", host)
    return f"{COOKIE}_{port[1]}" if port else COOKIE


class Logins:
    """Who is logged in; in memory only, so that a start of the server ends every login. Used by any thread."""

    def __init__(self) -> None:
        self._logins: OrderedDict[bytes, tuple[str, float]] = OrderedDict()

    def begin(self, key: str) -> str:
        """Logs the owner of a key in, and returns the text of the cookie."""
        text = secrets.token_urlsafe(32)
        self._logins[_digest(text)] = (key, time.monotonic() + LIFETIME)
        while len(self._logins) > _MOST:
            self._logins.popitem(last=False)
        return text

    def key(self, text: str) -> str | None:
        """Returns the id of the key that a cookie stands for; None where the login is over, or never was."""
        key, until = self._logins.get(_digest(text), ("", 0.0))
        return key if time.monotonic() < until else None

    def end(self, text: str) -> None:
        """Logs out; once more does no harm."""
        self._logins.pop(_digest(text), None)


def _digest(text: str) -> bytes:
    # Looking a digest up takes as long for one guess as for another.
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).digest()
