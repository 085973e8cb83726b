"""Logins of web pages: a cookie in place of the key, for as long as the key is valid and the server runs."""

from __future__ import annotations

import hashlib
import re
import secrets
import time
from collections import OrderedDict

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
