"""What use cases share: who asks, which version they have seen, and what their request is addressed to."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from skiros_py.errors import NotFound, Refused, StaleVersion, UnknownName

if TYPE_CHECKING:
    from skiros_py.station.station import Station


@dataclass(frozen=True, slots=True)
class Author:
    """Who asks: the author of what is written.

    Attributes:
        name: Their name.
        holder: Who their locks belong to; people of the same name are told apart by it.
    """

    name: str
    holder: str


class Service:
    """The use cases of one topic, which command line, library and server call alike.

    Args:
        station: The station.
    """

    def __init__(self, station: Station) -> None:
        self._station = station


LIBRARY: Final = Author("python", "python")
"""The author where a Python program calls the station without saying who it is."""


@dataclass(frozen=True, slots=True)
class Seen:
    """The version of something that its author has seen.

    Attributes:
        version: The version; None for whichever is the present one.
    """

    version: int | None = None


ANY_VERSION: Final = Seen()
"""For authors who want to overwrite whatever there is."""


def require_seen(seen: Seen | None, now: int) -> None:
    """Requires that the author has seen the present version.

    Args:
        seen: What they say; None where they say nothing.
        now: The present version.

    Raises:
        Refused: They say nothing.
        StaleVersion: They have seen another version.
    """
    if seen is None:
        raise Refused("VersionMissing", f'say which version you have seen: If-Match: "{now}" is the present one')
    if seen.version not in (None, now):
        raise StaleVersion(
            f"version {seen.version} is not the present one: it was changed since; look again", present=now
        )


@contextmanager
def addressed(code: str = "NotFound") -> Iterator[None]:
    """Says of an unknown name that the request is addressed to it; use it only around looking that up.

    Args:
        code: The kind of thing, for programs.

    Raises:
        NotFound: There is no such thing.
    """
    try:
        yield
    except UnknownName as error:
        raise NotFound.of(error, code) from None
